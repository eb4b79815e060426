// From a binary tree to a wide one, at least cost (plans.hpp). Nothing is lost: every reference of the tree is in a
// leaf, and adjacent pieces of one segment that meet in a leaf become one.
//
// The blocks of large subtrees are listed apart, each on a thread, and put behind those of the nodes above them: in the
// same places, however many threads there are.
#pragma once

#include "block_encoder.hpp"
#include "collapse_plan.hpp"
#include "leaf_splitter.hpp"

namespace fastlines {

template <RayPrimitive P>
class Collapse {
 public:
  Collapse(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, const CollapseCost& cost)
      : nodes_(nodes), refs_(refs), prims_(prims), cost_(cost) {}

  WideBvh operator()(unsigned n_threads, Progress& progress) {
    plans_ = CollapsePlanner(nodes_, refs_, cost_)(n_threads, progress);
    make_room(n_threads, progress);
    BlockCursor at{1, 0, 0};
    if (plans_[0].leaf) {
      // A root that is a leaf becomes the one child of a node.
      describe(wide_.nodes[0], at, 0, 1);
      list_pieces(0, at.leaf++, at);
    } else {
      put(0, 0, at, nodes_[0].n_refs > kApart);
    }
    parallel_for(
        apart_.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          BlockCursor next = apart_[i].begin;
          put(apart_[i].v, apart_[i].index, next, false);
          apart_[i].end = next;
        },
        {0.5, 0.7});
    close_gaps(at.ref);
    plans_ = {};
    wide_.frame = frame_of(nodes_[0].box);
    wide_.box = {wide_.frame(nodes_[0].box.lo), wide_.frame(nodes_[0].box.hi)};
    wide_.mean_extent = BlockEncoder(wide_.frame, wide_.nodes, wide_.leaves, wide_.refs, prims_, wide_.nodes.data(),
                                     wide_.leaves.data())(n_threads, progress, {0.7, 1.0});
    return std::move(wide_);
  }

 private:
  /// Where the next blocks stand, or how many there are.
  struct BlockCursor {
    std::size_t node, leaf, ref;
  };

  /// A subtree that is put apart: where its root stands, how much is below it, and where that begins and ends.
  struct Apart {
    std::uint32_t v;
    std::size_t index;
    BlockCursor size{}, begin{}, end{};
  };

  /// Subtrees of no more references are put apart.
  static constexpr std::uint32_t kApart = 1 << 14;

  /// Count all blocks, and find where those of each subtree begin. Pieces that are joined are not known yet.
  void make_room(unsigned n_threads, Progress& progress) {
    BlockCursor end{1, 0, 0};
    if (plans_[0].leaf)
      end = {1, 1, refs_.size()};
    else
      count(0, end, nodes_[0].n_refs > kApart);
    parallel_for(
        apart_.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          BlockCursor size{};
          count(apart_[i].v, size, false);
          apart_[i].size = size;
        },
        {0.4, 0.5});
    for (Apart& apart : apart_) {
      apart.begin = end;
      end = {end.node + apart.size.node, end.leaf + apart.size.leaf, end.ref + apart.size.ref};
    }
    wide_.nodes.make_room(end.node);
    wide_.leaves.make_room(end.leaf);
    wide_.refs.make_room(end.ref);
    wide_.nodes.keep(end.node);
    wide_.leaves.keep(end.leaf);
  }

  struct Some {
    std::uint32_t v[kSimdWidth];
    std::uint32_t n = 0;
  };

  /// The subtrees that become the children of one node, inner ones and leaves.
  struct Children {
    Some inner, leaves;
  };

  Children children_of(std::uint32_t v) const {
    struct Share {
      std::uint32_t v;
      int i;  // of the children
    };
    Children children;
    Share waiting[kSimdWidth];
    int n_waiting = 0;
    const auto part = [&](std::uint32_t parent, int i, int k) {
      waiting[n_waiting++] = {nodes_[parent].right, i - k};
      waiting[n_waiting++] = {parent + 1, k};
    };
    part(v, kSimdWidth, plans_[v].k_all);
    while (n_waiting > 0) {
      auto [below, i] = waiting[--n_waiting];
      while (i > 1 && plans_[below].k[i] == 0) --i;
      if (i > 1) {
        part(below, i, plans_[below].k[i]);
        continue;
      }
      Some& of_kind = plans_[below].leaf ? children.leaves : children.inner;
      of_kind.v[of_kind.n++] = below;
    }
    return children;
  }

  bool is_apart(std::uint32_t v) const { return nodes_[v].n_refs <= kApart; }

  /// A node of the tree that becomes a wide one, and where that stands.
  struct Wanted {
    std::uint32_t v;
    std::size_t index;
  };

  /// Call visit(node, its children) for a node and those below it, each before what is below it, the first child first;
  /// and in their turn leave(node) for those that are put apart, if any is to be. The inner children stand where `at`
  /// is before the call.
  template <class Visit, class Leave>
  void for_each_below(Wanted root, BlockCursor& at, bool some_apart, Visit&& visit, Leave&& leave) {
    std::vector<Wanted> waiting{root};
    while (!waiting.empty()) {
      const Wanted node = waiting.back();
      waiting.pop_back();
      if (some_apart && is_apart(node.v)) {
        leave(node);
        continue;
      }
      const Children children = children_of(node.v);
      const std::size_t first_inner = at.node;
      visit(node, children);
      for (std::uint32_t i = children.inner.n; i-- > 0;) waiting.push_back({children.inner.v[i], first_inner + i});
    }
  }

  /// Add the blocks below a node, but for those of subtrees that are put apart, if any is to be.
  void count(std::uint32_t v, BlockCursor& at, bool some_apart) {
    for_each_below(
        {v, 0}, at, some_apart,
        [&](const Wanted&, const Children& children) {
          const auto& [inner, leaves] = children;
          at.node += inner.n;
          at.leaf += leaves.n;
          for (std::uint32_t i = 0; i < leaves.n; ++i) at.ref += nodes_[leaves.v[i]].n_refs;
        },
        [&](const Wanted& node) { apart_.push_back({node.v, node.index}); });
  }

  static void describe(WideNode& node, const BlockCursor& first, std::uint32_t n_inner, std::uint32_t n_leaves) {
    node.first_inner = std::uint32_t(first.node);
    node.first_leaf = std::uint32_t(first.leaf);
    node.n_inner = std::uint8_t(n_inner);
    node.n_children = std::uint8_t(n_inner + n_leaves);
  }

  /// Put a node in its place, and the blocks below it in the next.
  void put(std::uint32_t v, std::size_t index, BlockCursor& at, bool some_apart) {
    for_each_below(
        {v, index}, at, some_apart,
        [&](const Wanted& node, const Children& children) {
          const auto& [inner, leaves] = children;
          const BlockCursor first = at;
          at.node += inner.n;
          at.leaf += leaves.n;
          describe(wide_.nodes[node.index], first, inner.n, leaves.n);
          for (std::uint32_t i = 0; i < leaves.n; ++i) list_pieces(leaves.v[i], first.leaf + i, at);
        },
        [](const Wanted&) {});
  }

  void list_pieces(std::uint32_t v, std::size_t index, BlockCursor& at) {
    Reference pieces[kMaxMergedRefs];
    const std::size_t n = merge_pieces(refs_.subspan(nodes_[v].first_ref, nodes_[v].n_refs), pieces);
    for (std::size_t i = 0; i < n; ++i) wide_.refs.data()[at.ref + i] = WideRef(pieces[i]);
    wide_.leaves[index].first_ref = std::uint32_t(at.ref);
    wide_.leaves[index].n_refs = std::uint32_t(n);
    at.ref += n;
  }

  /// Where pieces were joined, fewer references stand than there is room for. Those of the nodes above end
  /// at `end`.
  void close_gaps(std::size_t end) {
    for (const Apart& apart : apart_) {
      const std::size_t gap = apart.begin.ref - end;
      end = apart.end.ref - gap;
      if (gap == 0) continue;
      WideRef* const refs = wide_.refs.data();
      std::copy(refs + apart.begin.ref, refs + apart.end.ref, refs + apart.begin.ref - gap);
      for (std::size_t i = apart.begin.leaf; i < apart.end.leaf; ++i) wide_.leaves[i].first_ref -= std::uint32_t(gap);
    }
    wide_.refs.keep(end);
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  P prims_;
  CollapseCost cost_;
  Buffer<CollapsePlan> plans_;
  std::vector<Apart> apart_;
  WideBvh wide_;
};

template <RayPrimitive P>
WideBvh collapse(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, const CollapseCost& cost,
                 unsigned n_threads, Progress& progress) {
  const auto too_large = [](const Node& node) { return node.is_leaf() && node.n_refs > kSimdWidth; };
  if (std::none_of(nodes.begin(), nodes.end(), too_large))
    return Collapse(nodes, refs, prims, cost)(n_threads, progress);
  const Tree tree = split_large_leaves(nodes, refs, prims, kSimdWidth, progress);
  return Collapse(tree.nodes, tree.refs, prims, cost)(n_threads, progress);
}

}  // namespace fastlines
