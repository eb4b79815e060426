// Traverses a binary tree as it was built, by the boxes of its nodes.
#pragma once

#include <span>
#include <vector>

#include "../parallel/progress.hpp"
#include "../tree/tree.hpp"
#include "slabs.hpp"
#include "test_primitive.hpp"
#include "visited_set.hpp"

namespace fastlines {

/// Traverses depth first, the nearer child first. Skips subtrees that the ray enters beyond the collector's limit.
template <RayPrimitive P>
struct BinaryTraversal {
  static constexpr bool kTestsAll = false;

  /// Memory that a thread reuses from ray to ray.
  struct Scratch {
    struct Entry {
      std::uint32_t node;
      float enter;
    };
    Checkpoint* checkpoint = nullptr;
    std::vector<Entry> stack;
    VisitedSet visited;  // used unless pieces own hits
  };

  std::span<const Node> nodes;
  std::span<const Reference> refs;
  P prims;
  Frame frame;

  template <RayCollector C>
  void operator()(const RayOf<P>& ray, C& to, Scratch& scratch) const {
    constexpr float miss = kInfinity;
    const Slabs slabs(ray, frame, max_radius_of(prims));
    auto& stack = scratch.stack;
    stack.clear();
    if constexpr (!AxisPrimitive<P>) scratch.visited.clear();
    stack.push_back({0, slabs.enter(nodes[0].box, to.limit)});
    while (!stack.empty()) {
      auto [index, enter] = stack.back();
      stack.pop_back();
      if (!(enter <= to.limit)) continue;

      // Descend to a leaf; push the farther children.
      while (enter != miss && !nodes[index].is_leaf()) {
        std::uint32_t near = index + 1, far = nodes[index].right;
        float enter_near = slabs.enter(nodes[near].box, to.limit), enter_far = slabs.enter(nodes[far].box, to.limit);
        if (enter_far < enter_near) {
          std::swap(near, far);
          std::swap(enter_near, enter_far);
        }
        if (enter_far != miss) stack.push_back({far, enter_far});
        index = near;
        enter = enter_near;
      }
      if (enter == miss) continue;

      // Test the references of the leaf.
      const Node& leaf = nodes[index];
      if (scratch.checkpoint) scratch.checkpoint->pass(leaf.n_refs);
      if constexpr (!AxisPrimitive<P>) scratch.visited.reserve(leaf.n_refs);
      for (const Reference& ref : refs.subspan(leaf.first_ref, leaf.n_refs)) {
        if constexpr (!AxisPrimitive<P>)
          if (!scratch.visited.insert(ref.prim)) continue;
        if (test_primitive(prims, ray, frame, ref, to)) return;
      }
    }
  }
};

}  // namespace fastlines
