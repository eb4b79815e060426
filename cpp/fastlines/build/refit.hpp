// Refit: the same tree over segments that have moved. The topology and the pieces [s0, s1) stay. Each leaf's box is
// made tight around its pieces, and each inner box around its children's. The pieces tile their segments wherever these
// move, so queries stay exact; only the boxes are larger than a new tree's.
//
// Threads take ranges of the tree, subtrees of bounded size; the nodes above the ranges are fitted at the end. Within a
// range no branch depends on the tree's shape. First the boxes of all references are computed, then those of the
// leaves, then those of the inner nodes from the last to the first.
#pragma once

#include <memory>

#include "../parallel/parallel_for.hpp"
#include "../primitives/ray_primitive.hpp"
#include "../references/piece_endpoints.hpp"
#include "../tree/subtree_ranges.hpp"

namespace fastlines {

/// Constants of a refit; `fastlines-bench refit` times it.
struct RefitTuning {
  std::size_t range_nodes = 1024;  ///< the most nodes in a range: more take more scratch memory, fewer make more tasks
  std::size_t range_refs = 4096;   ///< the most references in a range, unless it is a single leaf
  std::size_t prefetch_distance = 16;  ///< how many references ahead primitives are prefetched
};

/// Writes the fitted nodes to `to`, which must have room for as many nodes as the tree has.
template <AxisPrimitive P>
class Refit {
 public:
  Refit(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, Node* to)
      : nodes_(nodes), refs_(refs), prims_(prims), to_(to) {}

  void operator()(unsigned n_threads, Progress& progress) {
    const SubtreeRanges ranges = subtree_ranges(nodes_, kNodes, kRefs);
    parallel_for(
        ranges.below.size(), n_threads, progress, [] { return std::make_unique_for_overwrite<Scratch>(); },
        [&](auto& scratch, std::size_t i) { fit(ranges.below[i], *scratch); });
    for (std::size_t k = ranges.above.size(); k-- > 0;) {
      const std::uint32_t i = ranges.above[k];
      Box box = to_[i + 1].box;
      box.grow(to_[nodes_[i].right].box);
      to_[i] = nodes_[i];
      to_[i].box = box;
    }
    if (has_empty_) place_empty();
  }

 private:
  static constexpr RefitTuning kTuning{};
  static constexpr std::size_t kNodes = kTuning.range_nodes, kRefs = kTuning.range_refs,
                               kPrefetchDistance = kTuning.prefetch_distance;

  /// The memory of a thread.
  struct Scratch {
    BoxX4 boxes[1 + kRefs + kNodes];  // an empty box, then the boxes of references, then those of nodes
    std::uint32_t leaves[kNodes], inner[kNodes];
  };

  /// Fit one range.
  void fit(const SubtreeRange& range, Scratch& scratch) {
    const Node* const nodes = &nodes_[range.begin];
    const std::size_t n_nodes = range.end - range.begin;
    if (n_nodes == 1) return store(range.begin, nodes[0], box_of_leaf(nodes[0]));
    const std::size_t n_refs = nodes[0].n_refs, first_ref = nodes[0].first_ref;
    BoxX4 *const of_refs = &scratch.boxes[1], *const of_nodes = of_refs + n_refs;
    scratch.boxes[0] = BoxX4::empty();
    fit_pieces(first_ref, n_refs, of_refs);

    // List the leaves and the inner nodes.
    std::size_t n_leaves = 0, n_inner = 0;
    for (std::uint32_t i = 0; i < n_nodes; ++i) {
      const bool leaf = nodes[i].is_leaf();
      scratch.leaves[n_leaves] = scratch.inner[n_inner] = i;
      n_leaves += leaf;
      n_inner += !leaf;
    }

    // Fit the leaves.
    bool any_empty = false;
    for (std::size_t k = 0; k < n_leaves; ++k) {
      const Node& node = nodes[scratch.leaves[k]];
      const std::size_t begin = node.first_ref - first_ref, end = begin + node.n_refs;
      any_empty |= node.n_refs == 0;
      // Grow by at least four pieces, repeating the last one, so that hardly any branch depends on the number.
      const std::size_t last = node.n_refs ? end : 0, first = std::min(begin + 1, last);
      BoxX4 box = scratch.boxes[first];
      for (std::size_t i = 1; i < 4; ++i) box.grow(scratch.boxes[std::min(first + i, last)]);
      for (std::size_t i = first + 4; i <= last; ++i) box.grow(scratch.boxes[i]);
      of_nodes[scratch.leaves[k]] = box;
    }
    if (any_empty) has_empty_ = true;
    // Fit the inner nodes, from the last to the first.
    for (std::size_t k = n_inner; k-- > 0;) {
      const std::size_t i = scratch.inner[k], right = nodes[i].right - std::size_t(range.begin);
      BoxX4 box = of_nodes[i + 1];
      box.grow(of_nodes[right]);
      of_nodes[i] = box;
    }
    for (std::size_t i = 0; i < n_nodes; ++i) store(range.begin + i, nodes[i], of_nodes[i]);
  }

  /// Compute the boxes of consecutive references. Their primitives are scattered in memory, so they are prefetched.
  void fit_pieces(std::size_t first, std::size_t n, BoxX4* boxes) const {
    const Reference* const refs = refs_.data() + first;
    const auto* const items = prims_.items();
    const auto fit = [&](std::size_t i) { boxes[i] = box_of(endpoints_of(P::axis(items[refs[i].prim]), refs[i])); };
    const std::size_t n_left = refs_.size() - first;
    const std::size_t n_ahead = std::min(n, n_left - std::min(n_left, kPrefetchDistance));
    for (std::size_t i = 0; i < n_ahead; ++i) {
      __builtin_prefetch(items + refs[i + kPrefetchDistance].prim);
      fit(i);
    }
    for (std::size_t i = n_ahead; i < n; ++i) fit(i);
  }

  /// The box of a leaf that is a range of its own, with any number of pieces.
  BoxX4 box_of_leaf(const Node& leaf) {
    if (leaf.n_refs == 0) has_empty_ = true;
    BoxX4 box = BoxX4::empty();
    for (const Reference& ref : refs_.subspan(leaf.first_ref, leaf.n_refs))
      box.grow(box_of(endpoints_of(P::axis(prims_.item(ref.prim)), ref)));
    return box;
  }

  /// Write a node. Each 16-byte copy of a corner spills lane 3 into the next field, which the next copy overwrites.
  void store(std::size_t i, const Node& node, const BoxX4& box) const {
    std::byte* const to = reinterpret_cast<std::byte*>(to_ + i);
    std::memcpy(to, &box.lo, sizeof box.lo);
    std::memcpy(to + offsetof(Node, box.hi), &box.hi, sizeof box.hi);
    std::memcpy(to + offsetof(Node, right), &node.right, sizeof(Node) - offsetof(Node, right));
  }

  /// Shrink the box of each node without references to a corner of its parent's box.
  void place_empty() const {
    if (to_[0].box.is_empty()) to_[0].box = nodes_[0].box;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!to_[i].is_leaf())
        for (const std::size_t child : {i + 1, std::size_t(to_[i].right)})
          if (to_[child].box.is_empty()) to_[child].box = {to_[i].box.lo, to_[i].box.lo};
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  P prims_;
  Node* to_;
  std::atomic<bool> has_empty_{false};
};

}  // namespace fastlines
