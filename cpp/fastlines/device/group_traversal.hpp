// Traces one ray in a group of 16 lanes, depth first: in the order of device_traversal.hpp, and with the same tests.
//
// Each lane tests a child of the node, then a piece of each leaf. A ballot tells all lanes which survive. Lanes whose
// piece survives test it exactly, all at once. Hits are shuffled to the group's leader, one after the other: only the
// leader's collector has them, and all lanes have its limit.
#pragma once

#include "device_traversal.hpp"

namespace fastlines {

/// Push the children of a mask: the nearest on top if they are sorted, and in their order otherwise.
template <bool sorted>
[[gnu::always_inline]] inline void push_children(GroupStack& stack, int size, std::uint32_t children,
                                                 std::uint32_t first_inner, const GroupLanes<float>& enter) {
  GroupLanes<int> places;
  GroupLanes<std::uint32_t> node;
  for_lanes([&](int lane) {
    places[lane] = size + (sorted ? 0 : count_bits(children & ((1u << lane) - 1)));
    node[lane] = first_inner + std::uint32_t(lane);
  });
  if constexpr (sorted) {
    // A child is above those that the ray enters later, and of equals above those with a lower number.
    for (std::uint32_t others = children; others; others &= others - 1) {
      const int other = lowest_bit(others);
      const float later = shuffle(enter, other);
      for_lanes([&](int lane) { places[lane] += enter[lane] < later || (enter[lane] == later && other < lane); });
    }
  }
  stack.set(children, size, places, node, enter);
}

/// A mask of the first n boxes of a block that the ray may hit before `limit`, and where it enters: t in the frame.
template <class Block>
[[gnu::always_inline]] inline std::uint32_t cull_boxes_by_group(const DeviceCullRay& ray, const Block& block,
                                                                const std::uint8_t* planes, int n, float limit,
                                                                GroupLanes<float>& enter) {
  const DeviceBoxCull cull(ray, block);
  GroupLanes<bool> survives;
  for_lanes([&](int lane) {
    const auto near = [&](int k) { return float(planes[kGroupLanes * ray.near_row[k] + lane]); };
    const auto far = [&](int k) { return float(planes[kGroupLanes * ray.far_row[k] + lane]); };
    survives[lane] = cull.clip(near, far, limit, enter[lane]) && lane < n;
  });
  return ballot(survives);
}

/// A mask of the pieces of a leaf that may come within the culling radius of the ray, or of its line.
template <class P>
[[gnu::always_inline]] inline std::uint32_t cull_pieces_by_group(const DeviceCullRay& ray, const WideLeaf& leaf) {
  if constexpr (P::kHasBoxes)
    if (leaf.shape == LeafShape::boxes) {
      GroupLanes<float> enter;
      return cull_boxes_by_group(ray, leaf, leaf.ends, leaf.n_refs, kInfinity, enter);
    }
  const DeviceAxisCull<P::kHasRadius> cull(ray, leaf);
  GroupLanes<bool> survives;
  for_lanes([&](int lane) {
    const auto at = [&](int end, int axis) { return float(leaf.ends[end_byte(end, axis, lane)]); };
    survives[lane] = lane < leaf.n_refs && cull.may_hit(at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2));
  });
  return ballot(survives);
}

/// Test the pieces of a leaf, and report hits to the leader's collector.
template <class P, class Collector>
[[gnu::always_inline]] inline void test_leaf_by_group(const DeviceScene& scene, const RayOf<P>& ray,
                                                      const DeviceCullRay& cull, const WideLeaf& leaf, Collector& to) {
  const std::uint32_t near = cull_pieces_by_group<P>(cull, leaf);
  if (!near) return;
  // Test the survivors.
  count_device_step(to, &DeviceSteps::n_tests, count_bits(near));
  GroupLanes<bool> is_hit{};
  GroupLanes<float> s{}, t{}, dist2{};
  for_lanes([&](int lane) {
    if (!(near >> lane & 1)) return;
    const std::uint64_t prim = scene.refs[leaf.first_ref + std::uint32_t(lane)].prim;
    const typename P::Test test = device_test<P>(ray, scene.items + prim * P::kFloats, scene.frame);
    if (!test.closest.hit) return;
    const ClosestApproach<float> approach = approach_at(to.at, test);
    is_hit[lane] = approach.hit;
    s[lane] = approach.s;
    t[lane] = approach.t;
    dist2[lane] = approach.dist2;
  });
  // Report the hits.
  std::uint32_t hits = ballot(is_hit);
  if (!hits) return;
  for (; hits; hits &= hits - 1) {
    const int lane = lowest_bit(hits);
    const ClosestApproach<float> approach{shuffle(s, lane), shuffle(t, lane), shuffle(dist2, lane), true};
    if (is_leader()) to.add(approach, scene.refs[leaf.first_ref + std::uint32_t(lane)]);
  }
  to.limit = from_leader(to.limit);
}

/// Report the hits of a ray to the leader's collector.
template <class P, RayCollector Collector>
void trace_by_group(const DeviceScene& scene, const RayOf<P>& ray, Collector& to) {
  const DeviceCullRay cull(ray);
  GroupStack stack;
  int size = 0;
  std::uint32_t index = 0;
  for (;;) {
    // Cull the children.
    count_device_step(to, &DeviceSteps::n_nodes);
    const WideNode& node = scene.nodes[index];
    GroupLanes<float> enter;
    const std::uint32_t children = cull_boxes_by_group(cull, node, node.planes, node.n_children, to.limit, enter);
    const std::uint32_t inner = children & ((1u << node.n_inner) - 1);
    if (inner) push_children<Collector::kShrinksLimit>(stack, size, inner, node.first_inner, enter);
    size += count_bits(inner);
    note_stack(size);
    // Visit the leaves.
    for (std::uint32_t leaves = children >> node.n_inner; leaves; leaves &= leaves - 1) {
      count_device_step(to, &DeviceSteps::n_leaves);
      test_leaf_by_group<P>(scene, ray, cull, scene.leaves[node.first_leaf + std::uint32_t(lowest_bit(leaves))], to);
    }
    // Pop the next node that is not beyond the limit.
    DeviceStackEntry top;
    do {
      if (size == 0) return;
      top = stack.get(--size);
    } while (!(top.enter <= to.limit));
    index = top.node;
  }
}

}  // namespace fastlines
