// Leaves that list more references than a block can hold, divided: any tree can be laid out.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../primitives/segments.hpp"
#include "../tree/tree.hpp"

namespace fastlines {

class LeafDivider {
 public:
  LeafDivider(std::span<const Node> nodes, std::span<const Reference> refs, std::span<const Segment> segments,
              std::size_t most)
      : nodes_(nodes), refs_(refs), segments_(segments), most_(most) {}

  Tree operator()() {
    copy(0);
    return std::move(tree_);
  }

 private:
  struct Piece {
    Reference ref;
    Box box;
  };

  /// Trees are as deep as settings allow, so recursion is safe.
  void copy(std::size_t v) {
    const Node& node = nodes_[v];
    const auto below = refs_.subspan(node.first_ref, node.n_refs);
    if (node.is_leaf() && node.n_refs > most_) {
      std::vector<Piece> pieces;
      for (const Reference& ref : below) {
        const Segment& segment = segments_[ref.prim];
        pieces.push_back({ref, Segment{segment.point(ref.s0), segment.point(std::min(ref.s1, 1.0f))}.bounds()});
      }
      return divide(pieces, node.box);
    }
    const std::size_t index = begin(node.box);
    if (node.is_leaf()) {
      tree_.refs.insert(tree_.refs.end(), below.begin(), below.end());
    } else {
      copy(v + 1);
      tree_.nodes[index].right = std::uint32_t(tree_.nodes.size());
      copy(node.right);
    }
    end(index);
  }

  /// Halve at the median centre of the longest axis.
  void divide(std::span<Piece> pieces, const Box& box) {
    const std::size_t index = begin(box);
    if (pieces.size() <= most_) {
      for (const Piece& piece : pieces) tree_.refs.push_back(piece.ref);
      return end(index);
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
    divide(left, hull(left));
    tree_.nodes[index].right = std::uint32_t(tree_.nodes.size());
    divide(right, hull(right));
    end(index);
  }

  static Box hull(std::span<const Piece> pieces) {
    Box box = Box::empty();
    for (const Piece& piece : pieces) box.grow(piece.box);
    return box;
  }

  std::size_t begin(const Box& box) {
    tree_.nodes.push_back({box, 0, std::uint32_t(tree_.refs.size()), 0});
    return tree_.nodes.size() - 1;
  }

  void end(std::size_t index) {
    tree_.nodes[index].n_refs = std::uint32_t(tree_.refs.size()) - tree_.nodes[index].first_ref;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  std::span<const Segment> segments_;
  std::size_t most_;
  Tree tree_;
};

inline Tree divide_leaves(std::span<const Node> nodes, std::span<const Reference> refs,
                          std::span<const Segment> segments, std::size_t most) {
  return LeafDivider(nodes, refs, segments, most)();
}

}  // namespace fastlines
