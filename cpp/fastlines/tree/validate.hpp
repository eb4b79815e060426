// Checks that a tree is what it claims to be: the axioms of thesis §3.2, the BVH or KD axiom, and Theorem 4. Checks run
// in double, with a tolerance of a few ulps of the scene where boxes were rounded, in time about linear in the tree,
// however deep it is.
//
// Axiom 5 is (∪p₁ ∩ q₁) ∪ (∪p₂ ∩ q₂) = ∪p ∩ q. It is checked primitive by primitive: the part of a primitive in q must
// lie in the boxes of the children that list the primitive. For curves the parts are intervals of s; for other
// primitives the boxes of the parts are compared. A tree over pieces is checked with the pieces as its primitives.
//
// Boxes are nested. Consider a path down the tree on which only one child of each node lists a primitive. Axiom 5 holds
// at all its nodes if the part of the primitive in the first box lies in the last. So axiom 5 is checked only where
// both children list the primitive, and on the path from there to the next such node or to the leaf. For a primitive in
// k leaves these are k − 1 nodes and 2k − 1 paths.
//
// Where axiom 5 holds, the content of a node is the content of its leaves. So for the BVH axiom, q = AABB(∪p ∩ q), the
// box of a node's content is the hull of its children's.
#pragma once

#include "../references/pieces.hpp"
#include "usable.hpp"

namespace fastlines {

/// Checks one tree, once; the references to its data must stay valid.
template <Primitives P>
class Validator : Usable<P> {
 public:
  using typename Usable<P>::Nodes, typename Usable<P>::References;

  Validator(const P& prims, Nodes nodes, References refs, BoxRule rule, const Progress& progress)
      : Usable<P>(prims, nodes, refs, rule, progress) {
    double largest = 0.0;
    const Box all = bounds_of_all(prims);
    if (!all.is_empty())
      for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(double(all.lo[k])), std::abs(double(all.hi[k]))});
    tolerance_ = std::max(std::ldexp(largest, -21), 2.0 * std::numeric_limits<float>::denorm_min());
  }

  /// The first violation found, if there is one.
  std::optional<Violation> operator()() {
    this->check_graph() && this->check_references() && this->check_root() && this->check_boxes() &&
        check_contents_of_leaves() && check_axiom_5() && check_bvh_axiom() && this->check_pieces();
    return found_;
  }

  /// The first violation of a tree over pieces: that pieces do not tile the primitives, or that the tree over them is
  /// not valid.
  std::optional<Violation> over_pieces()
    requires Straight<P>
  {
    if ((*this).Usable<P>::operator()()) return found_;
    const std::vector<Segment> pieces = pieces_of(prims_, refs_);
    return Validator<Segments>({pieces}, nodes_, references_to(pieces), rule_, progress_)();
  }

 private:
  using Usable<P>::prims_, Usable<P>::nodes_, Usable<P>::refs_, Usable<P>::rule_, Usable<P>::progress_,
      Usable<P>::found_;

  /// Check Theorem 4. Find the box of each leaf's content, and the leaf of each reference. Also find the node where the
  /// path to a reference parts from that to the previous reference to the same primitive.
  bool check_contents_of_leaves() {
    contents_.assign(nodes_.size(), Box::empty());
    leaf_of_.resize(refs_.size());
    parting_.assign(refs_.size(), kNoNode);
    std::vector<std::uint32_t> last_leaf(prims_.size(), kNoNode);
    std::vector<std::uint32_t> path;  // the nodes above the current one
    std::vector<std::size_t> ends;    // where their subtrees end
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      this->check_cancelled(i);
      while (!path.empty() && ends.back() <= i) {
        path.pop_back();
        ends.pop_back();
      }
      const Node& node = nodes_[i];
      if (!node.is_leaf()) {
        const bool is_left = !path.empty() && path.back() + 1 == i;
        ends.push_back(path.empty() ? nodes_.size() : is_left ? nodes_[path.back()].right : ends.back());
        path.push_back(i);
        continue;
      }
      const Box box = grown(node.box);
      const bool theorem_4 = node.box.area() > 0.0;
      for (std::size_t ref = node.first_ref; ref < std::size_t(node.first_ref) + node.n_refs; ++ref) {
        this->check_cancelled(ref);
        this->prefetch_ahead(ref);
        const std::uint32_t prim = refs_[ref].prim, previous = std::exchange(last_leaf[prim], i);
        leaf_of_[ref] = i;
        if (previous == i && !Curves<P>) return this->fail(i, "axiom 2", "it lists a primitive twice");
        if (previous != kNoNode && previous != i)
          parting_[ref] = *(std::upper_bound(path.begin(), path.end(), previous) - 1);
        const Box whole = prims_.bounds(prim), part = box.contains(whole) ? whole : prims_.clipped_bounds(prim, box);
        if (part.is_empty() && theorem_4)
          return this->fail(i, "Theorem 4",
                            "the leaf lists primitive " + std::to_string(prim) + ", which does not meet its box");
        contents_[i].grow(part);
      }
    }
    return true;
  }

  /// Check axiom 5. The nodes where the paths to a primitive's leaves part form a tree of their own. It is built from
  /// left to right; `open` is the path in it to the last leaf.
  bool check_axiom_5() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim) {
      this->check_cancelled(prim);
      open.clear();
      // Close the open nodes below `node`, and check the paths to them.
      const auto close = [&](std::uint32_t node) {
        while (open.size() > 1 && open[open.size() - 2] >= node) {
          const std::uint32_t below = open.back();
          open.pop_back();
          if (!check_path(prim, child_towards(open.back(), below), below)) return false;
        }
        return true;
      };
      for (const std::uint32_t ref : this->refs_to(prim)) {
        const std::uint32_t leaf = leaf_of_[ref], parting = parting_[ref];
        if (!open.empty() && open.back() == leaf) continue;
        if (parting != kNoNode) {
          if (!close(parting)) return false;
          if (const std::uint32_t below = open.back(); below > parting) {
            open.back() = parting;
            if (!check_path(prim, child_towards(parting, below), below)) return false;
            const Box &left = nodes_[parting + 1].box, &right = nodes_[nodes_[parting].right].box;
            if (!covered(prim, nodes_[parting].box, &left, &right)) return fail_axiom_5(parting, prim);
          }
        }
        open.push_back(leaf);
      }
      if (!close(0)) return false;
      if (!check_path(prim, 0, open.front())) return false;
    }
    return true;
  }

  /// The child of `node` on the path to `below`.
  std::uint32_t child_towards(std::uint32_t node, std::uint32_t below) const {
    return below < nodes_[node].right ? node + 1 : nodes_[node].right;
  }

  /// Check axiom 5 on a path on which only one child of each node lists the primitive.
  bool check_path(std::uint32_t prim, std::uint32_t from, std::uint32_t to) {
    if (from == to || grown(nodes_[to].box).contains(prims_.bounds(prim))) return true;
    if (covered(prim, nodes_[from].box, &nodes_[to].box, nullptr)) return true;
    // Find the node that violates it.
    std::uint32_t bad = from;
    for (std::uint32_t node = from; node != to;) {
      const std::uint32_t child = child_towards(node, to);
      if (!covered(prim, nodes_[node].box, &nodes_[child].box, nullptr)) bad = node;
      node = child;
    }
    return fail_axiom_5(bad, prim);
  }

  bool fail_axiom_5(std::uint32_t node, std::uint32_t prim) {
    return this->fail(node, "axiom 5", "a part of primitive " + std::to_string(prim) + " in it is in neither child");
  }

  /// Check the BVH axiom.
  bool check_bvh_axiom() {
    if (rule_ == BoxRule::cut) return true;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      this->check_cancelled(i);
      const Node& node = nodes_[i];
      if (node.n_refs == 0) continue;
      Box& tight = contents_[i];
      if (!node.is_leaf()) {
        tight = contents_[i + 1];
        tight.grow(contents_[node.right]);
      }
      for (int k = 0; k < 3; ++k)
        if (tight.lo[k] > node.box.lo[k] + 4 * tolerance_ || tight.hi[k] < node.box.hi[k] - 4 * tolerance_)
          return this->fail(i, "BVH axiom", "its box is not tight around its primitives");
    }
    return true;
  }

  /// Whether the part of a primitive in `box` lies in the boxes of the children that list it; null for a child that
  /// does not.
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

  /// A range of s.
  struct Interval {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    bool empty() const { return lo > hi; }
  };

  /// The range of s in which a segment lies in a box grown by `margin`.
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

  /// The box grown by the tolerance.
  Box grown(Box box) const {
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = float(box.lo[k] - tolerance_);
      box.hi[k] = float(box.hi[k] + tolerance_);
    }
    return box;
  }

  double tolerance_ = 0.0;
  std::vector<Box> contents_;           // by node: the box of the primitives' parts in it
  std::vector<std::uint32_t> leaf_of_;  // by reference: its leaf
  std::vector<std::uint32_t> parting_;  // by reference: where its path parts from the previous one's, or kNoNode
};

/// The first violation of a tree over whole or cut primitives, if there is one.
template <Primitives P>
std::optional<Violation> validate(const P& prims, std::span<const Node> nodes, std::span<const Reference> refs,
                                  BoxRule rule, const Progress& progress = {}) {
  return Validator<P>(prims, nodes, refs, rule, progress)();
}

/// The first violation of a tree over pieces, such as presplit, reinsertion and refits make.
template <Straight P>
std::optional<Violation> validate_pieces(const P& prims, std::span<const Node> nodes, std::span<const Reference> refs,
                                         BoxRule rule, const Progress& progress = {}) {
  return Validator<P>(prims, nodes, refs, rule, progress).over_pieces();
}

}  // namespace fastlines
