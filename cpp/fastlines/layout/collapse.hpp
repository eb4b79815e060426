// Collapses a binary tree into a wide BVH of least cost (collapse_plan.hpp). Each reference of the tree is in a leaf.
// Adjacent pieces of one segment are merged if a leaf has both.
//
// Subtrees of a bounded size are written as separate tasks, after the blocks of the nodes above them. Their indices do
// not depend on the number of threads.
#pragma once

#include "block_encoder.hpp"
#include "collapse_plan.hpp"
#include "leaf_splitter.hpp"
#include "piece_box.hpp"

namespace fastlines {

/// Collapses one tree, once. Precondition: no leaf lists more references than a block holds.
template <RayPrimitive P>
class Collapse {
 public:
  Collapse(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, const CollapseCost& cost,
           const Frame& frame)
      : nodes_(nodes), refs_(refs), prims_(prims), cost_(cost) {
    wide_.frame = frame;
  }

  WideBvh operator()(unsigned n_threads, Progress& progress) {
    plans_ = CollapsePlanner(nodes_, refs_, cost_)(n_threads, progress);
    allocate_blocks(n_threads, progress);
    BlockCursor at{1, 0, 0};
    if (plans_[0].leaf) {
      // A root that is a leaf becomes the only child of a node.
      set_children(wide_.nodes[0], at, 0, 1);
      list_pieces(0, at.leaf++, at);
    } else {
      write(0, 0, at, nodes_[0].n_refs > kMaxTaskRefs);
    }
    parallel_for(
        subtrees_.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          BlockCursor next = subtrees_[i].begin;
          write(subtrees_[i].v, subtrees_[i].index, next, false);
          subtrees_[i].end = next;
        },
        {0.5, 0.7});
    close_gaps(at.ref);
    plans_ = {};
    wide_.box = {wide_.frame(nodes_[0].box.lo), wide_.frame(nodes_[0].box.hi)};
    wide_.mean_extent = BlockEncoder(wide_.frame, wide_.nodes, wide_.leaves, wide_.refs, prims_, wide_.nodes.data(),
                                     wide_.leaves.data(), piece_boxes_)(n_threads, progress, {0.7, 1.0});
    return std::move(wide_);
  }

 private:
  /// The indices of the next node, leaf and reference; or numbers of nodes, leaves and references.
  struct BlockCursor {
    std::size_t node, leaf, ref;
  };

  /// A subtree that is a task of its own: its root v, the index of the root's wide node, the number of blocks below
  /// that node, and where these blocks begin and end.
  struct Subtree {
    std::uint32_t v;
    std::size_t index;
    BlockCursor size{}, begin{}, end{};
  };

  /// A subtree with at most this many references is a task of its own.
  static constexpr std::uint32_t kMaxTaskRefs = 1 << 14;

  /// Count all blocks, find where those of each subtree begin, and allocate them. Which pieces merge is not known yet,
  /// so every reference counts.
  void allocate_blocks(unsigned n_threads, Progress& progress) {
    BlockCursor end{1, 0, 0};
    if (plans_[0].leaf)
      end = {1, 1, refs_.size()};
    else
      count(0, end, nodes_[0].n_refs > kMaxTaskRefs);
    parallel_for(
        subtrees_.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          BlockCursor size{};
          count(subtrees_[i].v, size, false);
          subtrees_[i].size = size;
        },
        {0.4, 0.5});
    for (Subtree& subtree : subtrees_) {
      subtree.begin = end;
      end = {end.node + subtree.size.node, end.leaf + subtree.size.leaf, end.ref + subtree.size.ref};
    }
    wide_.nodes.reset(end.node);
    wide_.leaves.reset(end.leaf);
    wide_.refs.reset(end.ref);
    if (!AxisPrimitive<P>) piece_boxes_.resize(end.ref);
    wide_.nodes.set_size(end.node);
    wide_.leaves.set_size(end.leaf);
  }

  /// Roots of subtrees in the binary tree.
  struct SubtreeList {
    std::uint32_t v[kSimdWidth];
    std::uint32_t n = 0;
  };

  /// The subtrees that become the children of one wide node.
  struct Children {
    SubtreeList inner, leaves;
  };

  /// The children of the wide node that v becomes, by the plan.
  Children children_of(std::uint32_t v) const {
    struct Share {
      std::uint32_t v;
      int i;  // at most this many children
    };
    Children children;
    Share stack[kSimdWidth];
    int n_stack = 0;
    const auto push_halves = [&](std::uint32_t parent, int i, int k) {
      stack[n_stack++] = {nodes_[parent].right, i - k};
      stack[n_stack++] = {parent + 1, k};
    };
    push_halves(v, kSimdWidth, plans_[v].k_all);
    while (n_stack > 0) {
      auto [below, i] = stack[--n_stack];
      while (i > 1 && plans_[below].k[i] == 0) --i;
      if (i > 1) {
        push_halves(below, i, plans_[below].k[i]);
        continue;
      }
      SubtreeList& list = plans_[below].leaf ? children.leaves : children.inner;
      list.v[list.n++] = below;
    }
    return children;
  }

  bool is_task(std::uint32_t v) const { return nodes_[v].n_refs <= kMaxTaskRefs; }

  /// A node of the binary tree, and the index of the wide node that it becomes.
  struct NodeMapping {
    std::uint32_t v;
    std::size_t index;
  };

  /// Call visit(node, children) for a node and the nodes below it, in depth-first order, parents first. With
  /// `skip_tasks`, call skip(node) instead for subtrees that are tasks of their own. The indices of the inner children
  /// begin at the value that at.node has before the call of visit.
  template <class Visit, class Skip>
  void for_each_below(NodeMapping root, BlockCursor& at, bool skip_tasks, Visit&& visit, Skip&& skip) {
    std::vector<NodeMapping> stack{root};
    while (!stack.empty()) {
      const NodeMapping node = stack.back();
      stack.pop_back();
      if (skip_tasks && is_task(node.v)) {
        skip(node);
        continue;
      }
      const Children children = children_of(node.v);
      const std::size_t first_inner = at.node;
      visit(node, children);
      for (std::uint32_t i = children.inner.n; i-- > 0;) stack.push_back({children.inner.v[i], first_inner + i});
    }
  }

  /// Count the blocks below a node. With `skip_tasks`, list subtrees that are tasks of their own instead.
  void count(std::uint32_t v, BlockCursor& at, bool skip_tasks) {
    for_each_below(
        {v, 0}, at, skip_tasks,
        [&](const NodeMapping&, const Children& children) {
          const auto& [inner, leaves] = children;
          at.node += inner.n;
          at.leaf += leaves.n;
          for (std::uint32_t i = 0; i < leaves.n; ++i) at.ref += nodes_[leaves.v[i]].n_refs;
        },
        [&](const NodeMapping& node) { subtrees_.push_back({node.v, node.index}); });
  }

  /// Write the topology of a node.
  static void set_children(WideNode& node, const BlockCursor& first, std::uint32_t n_inner, std::uint32_t n_leaves) {
    node.first_inner = std::uint32_t(first.node);
    node.first_leaf = std::uint32_t(first.leaf);
    node.n_inner = std::uint8_t(n_inner);
    node.n_children = std::uint8_t(n_inner + n_leaves);
  }

  /// Write a node at `index`, and the blocks below it from `at` on.
  void write(std::uint32_t v, std::size_t index, BlockCursor& at, bool skip_tasks) {
    for_each_below(
        {v, index}, at, skip_tasks,
        [&](const NodeMapping& node, const Children& children) {
          const auto& [inner, leaves] = children;
          const BlockCursor first = at;
          at.node += inner.n;
          at.leaf += leaves.n;
          set_children(wide_.nodes[node.index], first, inner.n, leaves.n);
          for (std::uint32_t i = 0; i < leaves.n; ++i) list_pieces(leaves.v[i], first.leaf + i, at);
        },
        [](const NodeMapping&) {});
  }

  /// Write the merged references below v, and the leaf at `index` that lists them.
  void list_pieces(std::uint32_t v, std::size_t index, BlockCursor& at) {
    Reference pieces[kMaxMergedRefs];
    const std::size_t n = merge_pieces(refs_.subspan(nodes_[v].first_ref, nodes_[v].n_refs), pieces);
    for (std::size_t i = 0; i < n; ++i) wide_.refs.data()[at.ref + i] = WideRef(pieces[i]);
    wide_.leaves[index].first_ref = std::uint32_t(at.ref);
    wide_.leaves[index].n_refs = std::uint16_t(n);
    if constexpr (!AxisPrimitive<P>) set_piece_boxes(v, {pieces, n}, piece_boxes_.data() + at.ref);
    at.ref += n;
  }

  /// Write the boxes of the pieces below v. The references to a primitive make one piece.
  void set_piece_boxes(std::uint32_t v, std::span<const Reference> pieces, Box* boxes) const {
    std::fill_n(boxes, pieces.size(), Box::empty());
    const std::size_t end = nodes_[v].first_ref + std::size_t(nodes_[v].n_refs);
    for (std::size_t ref = nodes_[v].first_ref; ref < end; ++v) {
      if (!nodes_[v].is_leaf()) continue;
      for (const std::size_t last = ref + nodes_[v].n_refs; ref < last; ++ref) {
        const auto piece = std::ranges::lower_bound(pieces, refs_[ref].prim, {}, &Reference::prim);
        boxes[piece - pieces.begin()].grow(box_of_piece(prims_, refs_[ref], nodes_[v].box));
      }
    }
  }

  /// Close the gaps that merging has left between the references of subtrees. Those of the nodes above end at `end`.
  void close_gaps(std::size_t end) {
    for (const Subtree& subtree : subtrees_) {
      const std::size_t gap = subtree.begin.ref - end;
      end = subtree.end.ref - gap;
      if (gap == 0) continue;
      WideRef* const refs = wide_.refs.data();
      std::copy(refs + subtree.begin.ref, refs + subtree.end.ref, refs + subtree.begin.ref - gap);
      if (!piece_boxes_.empty())
        std::copy(piece_boxes_.begin() + std::ptrdiff_t(subtree.begin.ref),
                  piece_boxes_.begin() + std::ptrdiff_t(subtree.end.ref),
                  piece_boxes_.begin() + std::ptrdiff_t(subtree.begin.ref - gap));
      for (std::size_t i = subtree.begin.leaf; i < subtree.end.leaf; ++i)
        wide_.leaves[i].first_ref -= std::uint32_t(gap);
    }
    wide_.refs.set_size(end);
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  P prims_;
  CollapseCost cost_;
  Buffer<CollapsePlan> plans_;
  std::vector<Subtree> subtrees_;
  WideBvh wide_;
  std::vector<Box> piece_boxes_;  // of each reference, unless pieces are those of axes
};

/// The wide BVH of a binary tree, in the frame of a box that holds the tree's. Leaves with more references than a block
/// holds are split first.
template <RayPrimitive P>
WideBvh collapse(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, const CollapseCost& cost,
                 unsigned n_threads, Progress& progress, const Box& frame_box) {
  const Frame frame = frame_of(frame_box);
  const auto too_large = [](const Node& node) { return node.is_leaf() && node.n_refs > kSimdWidth; };
  if (std::none_of(nodes.begin(), nodes.end(), too_large))
    return Collapse(nodes, refs, prims, cost, frame)(n_threads, progress);
  const Tree tree = split_large_leaves(nodes, refs, prims, kSimdWidth, progress);
  return Collapse(tree.nodes, tree.refs, prims, cost, frame)(n_threads, progress);
}

/// The wide BVH in the frame of the tree's own box.
template <RayPrimitive P>
WideBvh collapse(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, const CollapseCost& cost,
                 unsigned n_threads, Progress& progress) {
  return collapse(nodes, refs, prims, cost, n_threads, progress, nodes[0].box);
}

}  // namespace fastlines
