// Traverses a KD tree by its planes (thesis §1.2.2, §1.3): an inner node is an axis and a plane, not two boxes.
//
// The ray carries the interval [t_enter, t_leave] in which it is inside the node's box grown by the radius. A plane
// splits the interval. The part before the plane ends where the ray crosses the plane moved forward by the radius. The
// part beyond begins where the ray crosses the plane moved back by the radius. So the intervals of two children
// overlap, and each equals the result of testing the child's grown box.
//
// The thesis counts a hit only inside the leaf that found it. Here a hit counts wherever it is found: with a radius,
// the ray may be outside all leaves that list the segment. A visited set (a mailbox: Amanatides and Woo 1987) tests
// each segment once per ray, so each hit counts once. A first hit cuts off every node that the ray enters beyond it.
#pragma once

#include "../parallel/progress.hpp"
#include "plane_tree.hpp"
#include "slabs.hpp"
#include "test_primitive.hpp"
#include "visited_set.hpp"

namespace fastlines {

/// Traverses depth first, the nearer child first. Skips nodes that the ray enters beyond the collector's limit.
template <RayPrimitive P>
struct PlaneTraversal {
  static constexpr bool kTestsAll = false;

  struct Scratch {
    struct Entry {
      std::uint32_t node;
      float t_enter, t_leave;
    };
    Checkpoint* checkpoint = nullptr;
    std::vector<Entry> stack;
    VisitedSet visited;
  };

  std::span<const PlaneNode> nodes;
  std::span<const std::uint32_t> refs;
  std::uint32_t depth;
  P prims;
  Box box;  ///< of the root
  Frame frame;

  template <RayCollector C>
  void operator()(const RayOf<P>& ray, C& to, Scratch& scratch) const {
    using Entry = typename Scratch::Entry;
    const Slabs slabs(ray, frame, max_radius_of(prims));
    // Each level pushes at most one node.
    if (scratch.stack.size() <= depth) scratch.stack.resize(depth + 1);
    scratch.visited.clear();
    const auto [root_enter, root_leave] = slabs.clip(box, to.limit);
    Entry *const bottom = scratch.stack.data(), *top = bottom;
    *top++ = {0, root_enter, root_leave};
    while (top != bottom) {
      auto [index, t_enter, t_leave] = *--top;
      t_leave = std::min(t_leave, to.limit);
      if (!(t_enter <= t_leave)) continue;

      // Descend to a leaf; push the farther children. The next child is unpredictable, so no branch depends on it.
      PlaneNode node = nodes[index];
      while (!node.is_leaf()) {
        const int axis = node.axis();
        const std::uint32_t i_near = node.lower_child() + slabs.is_backwards(axis), i_far = i_near ^ 1;
        const PlaneNode near = nodes[i_near], far = nodes[i_far];
        const float end_near = slabs.leave_before(axis, node.plane());
        const float begin_far = std::max(t_enter, slabs.enter_beyond(axis, node.plane()));
        const bool in_far = begin_far <= t_leave;
        const bool to_near = bool(int(end_near >= t_enter) & ~(int(in_far) & int(near.is_empty())));
        __builtin_prefetch(other_line(near));
        prefetch(far);
        *top = {i_far, begin_far, t_leave};
        top += to_near & in_far & !far.is_empty();
        node.word = to_near ? near.word : far.word;
        node.link = to_near ? near.link : far.link;
        t_leave = to_near ? std::min(t_leave, end_near) : t_leave;
        t_enter = to_near ? t_enter : begin_far;
      }

      // Test the primitives of the leaf that are not visited yet.
      const std::span<const std::uint32_t> below =
          node.n_refs() == 1 ? std::span(&node.word, 1) : refs.subspan(node.word, node.n_refs());
      if (scratch.checkpoint) scratch.checkpoint->pass(below.size());
      if (below.size() > 1)
        for (const std::uint32_t prim : below) __builtin_prefetch(prims.items() + prim);
      scratch.visited.reserve(below.size());
      for (const std::uint32_t prim : below) {
        if (!scratch.visited.insert(prim)) continue;
        if (test_primitive(prims, ray, frame, Reference{prim}, to)) return;
      }
    }
  }

 private:
  /// The other cache line of the block that holds the node's children.
  const void* other_line(const PlaneNode& node) const {
    constexpr std::uint32_t kLine = PlaneTree::kBlockPairs;
    return &nodes.data()[node.lower_child() ^ kLine];
  }

  /// Prefetch what a visit of the node reads first: the pair of its children, or its only primitive.
  [[gnu::always_inline]] void prefetch(const PlaneNode& node) const {
    const void* const item = prims.items() + (node.n_refs() == 1 ? node.word : 0);
    const void* const pair = &nodes.data()[node.lower_child()];
    __builtin_prefetch(node.is_leaf() ? item : pair);
  }
};

}  // namespace fastlines
