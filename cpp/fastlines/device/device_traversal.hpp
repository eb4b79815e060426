// Traces one ray in one thread, depth first.
//
// A node's children are tested one after the other. Inner ones go to the stack: sorted, the nearest on top, if hits
// lower the limit, and in their order otherwise. Then the leaves are culled and their survivors tested, and the next
// node is popped. The stack has the room that the tree needs (device_stack.hpp).
#pragma once

#include "../query/ray_collectors.hpp"
#include "device_cull.hpp"
#include "device_primitives.hpp"
#include "device_stack.hpp"
#include "records.hpp"

namespace fastlines {

/// The steps of a ray, for benchmarks: a collector that is also of this type counts them.
struct DeviceSteps {
  std::uint32_t n_nodes = 0, n_leaves = 0, n_tests = 0;
};

/// Count n steps, if the collector counts steps.
template <class Collector>
inline void count_device_step(Collector& to, std::uint32_t DeviceSteps::* step, int n = 1) {
  if constexpr (requires { to.n_nodes; }) to.*step += std::uint32_t(n);
}

/// Report the hits of a ray to the collector.
template <class P, RayCollector Collector>
void trace_by_thread(const DeviceScene& scene, const RayOf<P>& ray, Collector& to) {
  const DeviceCullRay cull(ray);
  ThreadStack stack;
  int size = 0;
  std::uint32_t index = 0;
  for (;;) {
    // Cull the children.
    count_device_step(to, &DeviceSteps::n_nodes);
    const WideNode& node = scene.nodes[index];
    const int bottom = size, n_inner = node.n_inner;
    std::uint32_t leaves = 0;
    cull_children(cull, node, to.limit, [&](int child, float enter) {
      if (child >= n_inner) {
        leaves |= 1u << (child - n_inner);
        return;
      }
      int place = size++;
      if constexpr (Collector::kShrinksLimit)
        for (; place > bottom; --place) {
          const DeviceStackEntry below = stack.get(place - 1);
          if (!(below.enter < enter)) break;
          stack.set(place, below);
        }
      stack.set(place, {node.first_inner + std::uint32_t(child), enter});
    });
    note_stack(size);
    // Cull the leaves, and test what survives.
    for (std::uint32_t leaf_index = node.first_leaf; leaves; leaves >>= 1, ++leaf_index) {
      if (!(leaves & 1)) continue;
      count_device_step(to, &DeviceSteps::n_leaves);
      const WideLeaf& leaf = scene.leaves[leaf_index];
      std::uint32_t near = cull_pieces<P>(cull, leaf);
      for (std::uint32_t i = leaf.first_ref; near; near >>= 1, ++i) {
        if (!(near & 1)) continue;
        count_device_step(to, &DeviceSteps::n_tests);
        const WideRef ref = scene.refs[i];
        const typename P::Test test =
            device_test<P>(ray, scene.items + std::uint64_t(ref.prim) * P::kFloats, scene.frame);
        if (!test.closest.hit) continue;
        const auto approach = approach_at(to.at, test);
        if (approach.hit) to.add(approach, ref);
      }
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
