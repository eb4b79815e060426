// Is this a tree? The axioms of thesis §3.2, the BVH or KD axiom, and Theorem 4, checked in double, with a tolerance of
// a few ulps of the scene where boxes were rounded.
//
// Axiom 5, (∪p₁ ∩ q₁) ∪ (∪p₂ ∩ q₂) = ∪p ∩ q, is checked primitive by primitive: what of one lies in q must lie in the
// box of a child that lists it. For curves the parts are intervals of s; of other primitives the boxes of the parts are
// compared. A tree over pieces is checked with the pieces as its primitives.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "../references/pieces.hpp"
#include "../splits/candidate.hpp"
#include "tree.hpp"

namespace fastlines {

struct Violation {
  std::size_t node;
  std::string axiom, detail;
};

template <Primitives P>
class Validator {
 public:
  using Nodes = std::span<const Node>;
  using References = std::span<const Reference>;

  Validator(const P& prims, Nodes nodes, References refs, BoxRule rule)
      : prims_(prims), nodes_(nodes), refs_(refs), rule_(rule) {
    double largest = 0.0;
    const Box all = bounds_of_all(prims);
    if (!all.is_empty())
      for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(double(all.lo[k])), std::abs(double(all.hi[k]))});
    tolerance_ = std::max(std::ldexp(largest, -21), 2.0 * std::numeric_limits<float>::denorm_min());
  }

  /// The first violation found, if there is one.
  std::optional<Violation> operator()() {
    check_graph() && check_references() && check_root() && check_nodes() && check_pieces();
    return found_;
  }

  /// The same of a tree over pieces: do they tile the primitives, and is it a tree over them?
  std::optional<Violation> over_pieces()
    requires std::same_as<P, Segments>
  {
    if (!(check_graph() && check_references() && check_root() && check_pieces())) return found_;
    const std::vector<Segment> pieces = pieces_of(prims_, refs_);
    return Validator(Segments{pieces}, nodes_, references_to(pieces), rule_)();
  }

 private:
  bool fail(std::size_t node, const char* axiom, std::string detail) {
    found_ = Violation{node, axiom, std::move(detail)};
    return false;
  }

  /// Axiom 1: a binary tree, in preorder; the references of a node are those of its children.
  bool check_graph() {
    if (nodes_.empty()) return fail(0, "axiom 1", "there is no root");
    std::vector<std::size_t> ends{nodes_.size()};  // where the subtrees that are open end
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      while (!ends.empty() && ends.back() == i) ends.pop_back();
      if (ends.empty()) return fail(i, "axiom 1", "it is nobody's child");
      if (std::size_t(node.first_ref) + node.n_refs > refs_.size())
        return fail(i, "axiom 2", "its references reach past the end of the list");
      if (node.is_leaf()) {
        if (ends.back() != i + 1) return fail(i, "axiom 1", "a leaf, where an inner node is due");
        continue;
      }
      if (node.right <= i + 1 || node.right >= ends.back())
        return fail(i, "axiom 1", "its right child " + std::to_string(node.right) + " is not in its own subtree");
      ends.push_back(node.right);
      const Node &left = nodes_[i + 1], &right = nodes_[node.right];
      if (left.first_ref != node.first_ref || right.first_ref != left.first_ref + left.n_refs ||
          node.n_refs != left.n_refs + right.n_refs)
        return fail(i, "axiom 2", "its references are not those of its two children");
    }
    if (nodes_[0].first_ref != 0 || nodes_[0].n_refs != refs_.size())
      return fail(0, "axiom 3", "not all references are below the root");
    return true;
  }

  /// Axiom 2: boxes are boxes, and references name primitives and pieces.
  bool check_references() {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const float lo = nodes_[i].box.lo[k], hi = nodes_[i].box.hi[k];
        if (!(lo <= hi) || std::isinf(lo) || std::isinf(hi)) return fail(i, "axiom 2", "its box is not a box");
      }
    for (std::size_t i = 0; i < refs_.size(); ++i)
      if (refs_[i].prim >= prims_.size() || !is_piece(refs_[i]))
        return fail(leaf_of(i), "axiom 2", "reference " + std::to_string(i) + " is not a piece of a primitive");
    return true;
  }

  /// Only curves are cut into pieces.
  static bool is_piece(const Reference& ref) {
    return Curves<P> ? 0.0f <= ref.s0 && ref.s0 <= ref.s1 : ref.s0 == 0.0f && std::isinf(ref.s1);
  }

  /// Axiom 3: the root is (P, AABB(∪P)).
  bool check_root() {
    if (prims_.size() == 0) return refs_.empty() || fail(0, "axiom 3", "it lists references of no primitives");
    if (!(nodes_[0].box == bounds_of_all(prims_)))
      return fail(0, "axiom 3", "the root's box does not bound the primitives tightly");
    std::vector<bool> listed(prims_.size());
    for (const Reference& ref : refs_) listed[ref.prim] = true;
    for (std::size_t prim = 0; prim < listed.size(); ++prim)
      if (!listed[prim]) return fail(0, "axiom 3", "primitive " + std::to_string(prim) + " is in no leaf");
    return true;
  }

  /// Axioms 4 and 5, the axiom of the box rule, and Theorem 4, from the last node to the first.
  bool check_nodes() {
    std::vector<std::vector<std::uint32_t>> prims_of(nodes_.size());
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      const Node& node = nodes_[i];
      std::vector<std::uint32_t>& prims = prims_of[i];
      if (node.is_leaf()) {
        for (const Reference& ref : refs_.subspan(node.first_ref, node.n_refs)) prims.push_back(ref.prim);
        std::sort(prims.begin(), prims.end());
        const auto last = std::unique(prims.begin(), prims.end());
        if (!Curves<P> && last != prims.end()) return fail(i, "axiom 2", "it lists a primitive twice");
        prims.erase(last, prims.end());
      } else {
        const Box &left = nodes_[i + 1].box, &right = nodes_[node.right].box;
        if (!node.box.contains(left) || !node.box.contains(right))
          return fail(i, "axiom 4", "the boxes of its children do not lie in its own");
        if (rule_ == BoxRule::cut && !cut_in_two(node.box, left, right))
          return fail(i, "KD axiom", "the boxes of its children do not cut its own in two");
        std::vector<std::uint32_t>&l = prims_of[i + 1], &r = prims_of[node.right];
        std::set_union(l.begin(), l.end(), r.begin(), r.end(), std::back_inserter(prims));
        for (const std::uint32_t prim : prims) {
          const bool in_left = std::binary_search(l.begin(), l.end(), prim);
          const bool in_right = std::binary_search(r.begin(), r.end(), prim);
          if (!covered(prim, node.box, in_left ? &left : nullptr, in_right ? &right : nullptr))
            return fail(i, "axiom 5", "a part of primitive " + std::to_string(prim) + " in it is in neither child");
        }
        l = {};
        r = {};
      }
      if (!check_contents(i, prims)) return false;
    }
    return true;
  }

  /// Theorem 4 at a leaf, and the BVH axiom, q = AABB(∪p ∩ q).
  bool check_contents(std::size_t i, const std::vector<std::uint32_t>& prims) {
    const Node& node = nodes_[i];
    const bool theorem_4 = node.is_leaf() && node.box.area() > 0.0;
    if (prims.empty() || (rule_ == BoxRule::cut && !theorem_4)) return true;
    Box tight = Box::empty();
    for (const std::uint32_t prim : prims) {
      const Box part = prims_.clipped_bounds(prim, grown(node.box));
      if (part.is_empty() && theorem_4)
        return fail(i, "Theorem 4",
                    "the leaf lists primitive " + std::to_string(prim) + ", which does not meet its box");
      tight.grow(part);
    }
    if (rule_ == BoxRule::cut) return true;
    for (int k = 0; k < 3; ++k)
      if (tight.lo[k] > node.box.lo[k] + 4 * tolerance_ || tight.hi[k] < node.box.hi[k] - 4 * tolerance_)
        return fail(i, "BVH axiom", "its box is not tight around its primitives");
    return true;
  }

  /// Each hit is found once because the pieces of a primitive tile it, and found at all because they lie in their
  /// leaves.
  bool check_pieces() {
    struct Piece {
      Reference ref;
      std::size_t index;
    };
    std::vector<Piece> pieces(refs_.size());
    for (std::size_t i = 0; i < refs_.size(); ++i) pieces[i] = {refs_[i], i};
    if constexpr (!Curves<P>) return true;
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      if (a.ref.prim != b.ref.prim) return a.ref.prim < b.ref.prim;
      return a.ref.s0 != b.ref.s0 ? a.ref.s0 < b.ref.s0 : a.ref.s1 < b.ref.s1;
    });
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Reference& ref = pieces[i].ref;
      const bool first = i == 0 || pieces[i - 1].ref.prim != ref.prim;
      const bool last = i + 1 == pieces.size() || pieces[i + 1].ref.prim != ref.prim;
      if (ref.s0 != (first ? 0.0f : pieces[i - 1].ref.s1) || std::isinf(ref.s1) != last)
        return fail(leaf_of(pieces[i].index), "axiom 5",
                    "the pieces of primitive " + std::to_string(ref.prim) + " do not tile it");
    }
    if constexpr (Curves<P>)
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!nodes_[i].is_leaf()) continue;
        const Box box = grown(nodes_[i].box);
        for (const Reference& ref : refs_.subspan(nodes_[i].first_ref, nodes_[i].n_refs)) {
          Box ends = Box::empty();
          ends.grow(prims_.curve(ref.prim).point(ref.s0));
          ends.grow(prims_.curve(ref.prim).point(std::min(ref.s1, 1.0f)));
          if (!box.contains(ends))
            return fail(i, "axiom 5", "a piece of primitive " + std::to_string(ref.prim) + " is not in its leaf's box");
        }
      }
    return true;
  }

  /// Whether the part of a primitive in `box` lies in the boxes of the children that list it (null = does not).
  bool covered(std::uint32_t prim, const Box& box, const Box* left, const Box* right) const {
    if constexpr (Curves<P>) {
      const Interval whole = part_of(prim, box, 0.0);
      if (whole.empty()) return true;
      Interval a, b;
      if (left) a = part_of(prim, *left, tolerance_);
      if (right) b = part_of(prim, *right, tolerance_);
      if (b.lo < a.lo) std::swap(a, b);
      // A gap shorter than the tolerance is rounding.
      const Box bounds = prims_.bounds(prim);
      const double length = std::max({bounds.side(0), bounds.side(1), bounds.side(2)});
      const double slack = length > 0.0 ? tolerance_ / length : 1.0;
      double reached = whole.lo;
      for (const Interval& part : {a, b})
        if (!part.empty() && part.lo <= reached + slack) reached = std::max(reached, part.hi);
      return reached + slack >= whole.hi;
    } else {
      const Box whole = prims_.clipped_bounds(prim, box);
      Box parts = Box::empty();
      if (left) parts.grow(prims_.clipped_bounds(prim, *left));
      if (right) parts.grow(prims_.clipped_bounds(prim, *right));
      return whole.is_empty() || (!parts.is_empty() && grown(parts).contains(whole));
    }
  }

  struct Interval {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    bool empty() const { return lo > hi; }
  };

  /// The s of a segment that lie in a box grown by `margin`.
  Interval part_of(std::uint32_t prim, const Box& box, double margin) const
    requires Curves<P>
  {
    const Vec3 p = prims_.curve(prim).point(0.0f), q = prims_.curve(prim).point(1.0f);
    Interval part{0.0, 1.0};
    for (int k = 0; k < 3; ++k) {
      const double lo = box.lo[k] - margin - p[k], hi = box.hi[k] + margin - p[k], e = double(q[k]) - p[k];
      if (e == 0.0) {
        if (lo > 0.0 || hi < 0.0) return {};
        continue;
      }
      part.lo = std::max(part.lo, std::min(lo / e, hi / e));
      part.hi = std::min(part.hi, std::max(lo / e, hi / e));
    }
    return part;
  }

  Box grown(Box box) const {
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = float(box.lo[k] - tolerance_);
      box.hi[k] = float(box.hi[k] + tolerance_);
    }
    return box;
  }

  static bool cut_in_two(const Box& box, const Box& left, const Box& right) {
    int n_cut = 0;
    for (int k = 0; k < 3; ++k) {
      if (left.lo[k] != box.lo[k] || right.hi[k] != box.hi[k]) return false;
      if (left.hi[k] == box.hi[k] && right.lo[k] == box.lo[k]) continue;
      if (left.hi[k] != right.lo[k]) return false;
      ++n_cut;
    }
    return n_cut == 1;
  }

  std::size_t leaf_of(std::size_t ref) const {
    std::size_t i = 0;
    while (!nodes_[i].is_leaf()) i = ref < nodes_[nodes_[i].right].first_ref ? i + 1 : nodes_[i].right;
    return i;
  }

  const P& prims_;
  Nodes nodes_;
  References refs_;
  BoxRule rule_;
  double tolerance_ = 0.0;
  std::optional<Violation> found_;
};

/// A tree over pieces of segments, as presplit and reinsertion make it.
inline std::optional<Violation> validate_pieces(const Segments& segments, std::span<const Node> nodes,
                                                std::span<const Reference> refs, BoxRule rule) {
  return Validator(segments, nodes, refs, rule).over_pieces();
}

template <Primitives P>
std::optional<Violation> validate(const P& prims, std::span<const Node> nodes, std::span<const Reference> refs,
                                  BoxRule rule) {
  return Validator<P>(prims, nodes, refs, rule)();
}

}  // namespace fastlines
