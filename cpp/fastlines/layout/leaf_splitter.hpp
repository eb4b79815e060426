// Leaves that list more references than a block can hold, divided: any tree can be laid out.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../parallel/progress.hpp"
#include "../primitives/ray_primitive.hpp"
#include "../tree/tree.hpp"

namespace fastlines {

template <RayPrimitive P>
class LeafSplitter {
 public:
  LeafSplitter(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, std::size_t most,
               const Progress& progress)
      : nodes_(nodes), refs_(refs), prims_(prims), most_(most), progress_(progress) {}

  Tree operator()() {
    tree_.refs.reserve(refs_.size());
    std::vector<std::uint32_t> place(nodes_.size());  // of each node, in the tree that is made
    for (std::size_t v = 0; v < nodes_.size(); ++v) {
      if (v % 4096 == 0) progress_.check();
      const Node& node = nodes_[v];
      place[v] = std::uint32_t(tree_.nodes.size());
      if (node.is_leaf() && node.n_refs > most_) {
        split(node);
      } else {
        tree_.nodes.push_back(node);
        if (node.is_leaf()) list(refs_.subspan(node.first_ref, node.n_refs));
      }
    }
    for (std::size_t v = 0; v < nodes_.size(); ++v)
      if (!nodes_[v].is_leaf()) tree_.nodes[place[v]].right = place[nodes_[v].right];
    return std::move(tree_);
  }

 private:
  struct Piece {
    Reference ref;
    Box box;
  };

  /// Pieces that become a subtree, and the node that it becomes the right child of; the root of all and left children
  /// have none.
  struct Part {
    std::span<Piece> pieces;
    Box box;
    std::uint32_t parent = kNone;
  };
  static constexpr std::uint32_t kNone = std::uint32_t(-1);

  /// Halve at the median centre of the longest axis.
  void split(const Node& leaf) {
    std::vector<Piece> all;
    for (const Reference& ref : refs_.subspan(leaf.first_ref, leaf.n_refs)) {
      const Segment& segment = P::axis(prims_.item(ref.prim));
      all.push_back({ref, Segment{segment.point(ref.s0), segment.point(std::min(ref.s1, 1.0f))}.bounds()});
    }
    std::vector<Part> waiting{{all, leaf.box}};
    while (!waiting.empty()) {
      const auto [pieces, box, parent] = waiting.back();
      waiting.pop_back();
      progress_.check();
      const auto index = std::uint32_t(tree_.nodes.size());
      if (parent != kNone) tree_.nodes[parent].right = index;
      tree_.nodes.push_back({box, 0, std::uint32_t(tree_.refs.size()), std::uint32_t(pieces.size())});
      if (pieces.size() <= most_) {
        for (const Piece& piece : pieces) tree_.refs.push_back(piece.ref);
        continue;
      }
      const int axis = box.longest_axis();
      const auto centre = [axis](const Piece& piece) { return double(piece.box.lo[axis]) + piece.box.hi[axis]; };
      const auto middle = pieces.begin() + std::ptrdiff_t(pieces.size() / 2);
      std::nth_element(pieces.begin(), middle, pieces.end(), [&](const Piece& a, const Piece& b) {
        const double ca = centre(a), cb = centre(b);
        if (ca != cb) return ca < cb;
        return a.ref.prim != b.ref.prim ? a.ref.prim < b.ref.prim : a.ref.s0 < b.ref.s0;
      });
      const std::span<Piece> left(pieces.begin(), middle), right(middle, pieces.end());
      waiting.push_back({right, hull(right), index});
      waiting.push_back({left, hull(left)});
    }
  }

  static Box hull(std::span<const Piece> pieces) {
    Box box = Box::empty();
    for (const Piece& piece : pieces) box.grow(piece.box);
    return box;
  }

  void list(std::span<const Reference> refs) { tree_.refs.insert(tree_.refs.end(), refs.begin(), refs.end()); }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  P prims_;
  std::size_t most_;
  const Progress& progress_;
  Tree tree_;
};

template <RayPrimitive P>
Tree split_large_leaves(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, std::size_t most,
                        const Progress& progress) {
  return LeafSplitter(nodes, refs, prims, most, progress)();
}

}  // namespace fastlines
