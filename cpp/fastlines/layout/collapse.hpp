// From a binary tree to a wide one, at least cost (plans.hpp). Nothing is lost: every reference of the tree is in a
// leaf, and adjacent pieces of one segment that meet in a leaf become one.
//
// The blocks of large subtrees are listed apart, each on a thread, and put behind those of the nodes above them: in the
// same places, however many threads there are.
#pragma once

#include "divide.hpp"
#include "fit.hpp"
#include "plans.hpp"

namespace fastlines {

class Collapse {
 public:
  Collapse(std::span<const Node> nodes, std::span<const Reference> refs, std::span<const Segment> segments,
           const CollapseCost& cost)
      : nodes_(nodes), refs_(refs), segments_(segments), cost_(cost) {}

  WideTree operator()(unsigned n_threads, Progress& progress) {
    plans_ = Planner(nodes_, refs_, cost_)(n_threads, progress);
    Blocks above;
    above.nodes.emplace_back();
    if (plans_[0].leaf) {
      // A root that is a leaf becomes the one child of a node.
      above.nodes[0].n_children = 1;
      above.leaves.emplace_back();
      list_pieces(0, above, 0);
    } else {
      list_node(0, above, 0, true);
    }
    std::vector<Blocks> parts(apart_.size());
    for_each_chunk(
        parts.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          const std::size_t n_refs = nodes_[apart_[i].v].n_refs;
          parts[i].refs.reserve(n_refs);
          parts[i].nodes.emplace_back();
          list_node(apart_[i].v, parts[i], 0, false);
        },
        {0.4, 0.6});
    WideTree wide = put_together(above, parts, n_threads, progress);
    wide.frame = frame_of(nodes_[0].box);
    wide.box = {wide.frame(nodes_[0].box.lo), wide.frame(nodes_[0].box.hi)};
    wide.mean_extent = Fit(wide.frame, wide.nodes, wide.leaves, wide.refs, segments_, wide.nodes.data(),
                           wide.leaves.data())(n_threads, progress, {0.7, 1.0});
    return wide;
  }

 private:
  /// Blocks that name each other by their places among these.
  struct Blocks {
    LargeVector<WideNode> nodes;
    LargeVector<WideLeaf> leaves;
    LargeVector<Reference> refs;
    std::vector<Reference> pieces;  // scratch
  };

  /// A subtree that is listed apart, and the place of its root among the nodes above.
  struct Apart {
    std::uint32_t v;
    std::size_t index;
  };

  static constexpr std::uint32_t kApart = 1 << 14;

  struct Some {
    std::uint32_t v[kWidth];
    std::uint32_t n = 0;
  };

  /// The subtrees that become the children of one node, inner ones and leaves.
  struct Children {
    Some inner, leaves;
  };

  void list_children(std::uint32_t v, int i, Children& to) const {
    while (i > 1 && plans_[v].k[i] == 0) --i;
    if (i == 1) {
      Some& of_kind = plans_[v].leaf ? to.leaves : to.inner;
      of_kind.v[of_kind.n++] = v;
      return;
    }
    const int k = plans_[v].k[i];
    list_children(v + 1, k, to);
    list_children(nodes_[v].right, i - k, to);
  }

  void list_node(std::uint32_t v, Blocks& to, std::size_t index, bool may_part) {
    Children children;
    const int k = plans_[v].k_all;
    list_children(v + 1, k, children);
    list_children(nodes_[v].right, kWidth - k, children);
    const auto& [inner, leaves] = children;
    const std::size_t first_inner = to.nodes.size(), first_leaf = to.leaves.size();
    to.nodes.resize(first_inner + inner.n);
    to.leaves.resize(first_leaf + leaves.n);
    WideNode& node = to.nodes[index];
    node.first_inner = std::uint32_t(first_inner);
    node.first_leaf = std::uint32_t(first_leaf);
    node.n_inner = std::uint8_t(inner.n);
    node.n_children = std::uint8_t(inner.n + leaves.n);
    for (std::uint32_t i = 0; i < leaves.n; ++i) list_pieces(leaves.v[i], to, first_leaf + i);
    for (std::uint32_t i = 0; i < inner.n; ++i)
      if (may_part && nodes_[inner.v[i]].n_refs <= kApart)
        apart_.push_back({inner.v[i], first_inner + i});
      else
        list_node(inner.v[i], to, first_inner + i, may_part);
  }

  void list_pieces(std::uint32_t v, Blocks& to, std::size_t index) const {
    join_pieces(refs_.subspan(nodes_[v].first_ref, nodes_[v].n_refs), to.pieces);
    to.leaves[index].first_ref = std::uint32_t(to.refs.size());
    to.leaves[index].n_refs = std::uint32_t(to.pieces.size());
    to.refs.insert(to.refs.end(), to.pieces.begin(), to.pieces.end());
  }

  /// The blocks above, then those of each part but for its root, which is among those above.
  WideTree put_together(Blocks& above, std::vector<Blocks>& parts, unsigned n_threads, Progress& progress) const {
    WideTree wide;
    wide.nodes = std::move(above.nodes);
    wide.leaves = std::move(above.leaves);
    wide.refs = std::move(above.refs);
    struct Place {
      std::size_t node, leaf, ref;
    };
    std::vector<Place> places;
    Place end{wide.nodes.size(), wide.leaves.size(), wide.refs.size()};
    for (const Blocks& part : parts) {
      places.push_back(end);
      end = {end.node + part.nodes.size() - 1, end.leaf + part.leaves.size(), end.ref + part.refs.size()};
    }
    wide.nodes.resize(end.node);
    wide.leaves.resize(end.leaf);
    wide.refs.resize(end.ref);
    for_each_chunk(
        parts.size(), n_threads, progress, [] { return 0; },
        [&](int, std::size_t i) {
          Blocks& part = parts[i];
          const Place& place = places[i];
          for (WideNode& node : part.nodes) {
            node.first_inner += std::uint32_t(place.node - 1);
            node.first_leaf += std::uint32_t(place.leaf);
          }
          for (WideLeaf& leaf : part.leaves) leaf.first_ref += std::uint32_t(place.ref);
          wide.nodes[apart_[i].index] = part.nodes[0];
          std::copy(part.nodes.begin() + 1, part.nodes.end(), wide.nodes.begin() + std::ptrdiff_t(place.node));
          std::copy(part.leaves.begin(), part.leaves.end(), wide.leaves.begin() + std::ptrdiff_t(place.leaf));
          std::copy(part.refs.begin(), part.refs.end(), wide.refs.begin() + std::ptrdiff_t(place.ref));
          part = {};
        },
        {0.6, 0.7});
    return wide;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  std::span<const Segment> segments_;
  CollapseCost cost_;
  LargeVector<Plan> plans_;
  std::vector<Apart> apart_;
};

inline WideTree collapse(std::span<const Node> nodes, std::span<const Reference> refs,
                         std::span<const Segment> segments, const CollapseCost& cost, unsigned n_threads,
                         Progress& progress) {
  const auto too_large = [](const Node& node) { return node.is_leaf() && node.n_refs > kWidth; };
  if (std::none_of(nodes.begin(), nodes.end(), too_large))
    return Collapse(nodes, refs, segments, cost)(n_threads, progress);
  const Tree tree = divide_leaves(nodes, refs, segments, kWidth);
  return Collapse(tree.nodes, tree.refs, segments, cost)(n_threads, progress);
}

}  // namespace fastlines
