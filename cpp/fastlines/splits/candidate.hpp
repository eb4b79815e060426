// A candidate: one way to split a node, with the counts and boxes that its cost needs.
//
// A split set (SPLITS of the thesis) passes its candidates for a node to a visitor:
//
//     set.visit(prims, refs, box, rule, [](const Candidate&) { … });
//
// It counts references and moves none. `partition` (partition.hpp) applies a candidate, and the builder takes its
// counts and boxes as they are: they must be those of the children that `partition` makes.
//
// An object split cuts no reference: each goes whole to one child, and the children's boxes may overlap. A plane, or
// spatial split, cuts the references that straddle it.
#pragma once

#include <algorithm>
#include <span>
#include <tuple>
#include <vector>

#include "../memory/function_ref.hpp"
#include "../primitives/segments.hpp"
#include "../references/cut.hpp"
#include "../simd/box_x4.hpp"
#include "box_rule.hpp"
#include "measure.hpp"

namespace fastlines {

struct Candidate {
  /// How references are assigned to the children:
  ///   objects: the first n_left in the order of `ByCentre` go left.
  ///   centres: those whose centre lies left of the plane go left.
  ///   plane: by `side_of`; those that straddle the plane are cut.
  enum class Kind { objects, centres, plane } kind;
  int axis;
  float plane;  ///< unused for objects
  std::size_t n_left;
  std::size_t n_right;
  Box left, right;  ///< the boxes of the children

  /// The cost of the children as leaves: tests, weighted by the children's areas.
  double sah(const Measure& measure) const {
    return measure.area(left) * measure.tests(n_left) + measure.area(right) * measure.tests(n_right);
  }
};

using Refs = std::span<const BuildRef>;

/// Receives the candidates for a node.
using CandidateVisitor = FunctionRef<void(const Candidate&)>;

/// A type of split sets: what it declares besides `visit`, a template that a concept cannot name.
template <class Set>
concept CandidateSet = requires {
  /// Whether all candidates are object splits. These need tight boxes: `visit` is called only for BoxRule::tight. It is
  /// also called for nodes of more than `max_refs` references if a limit or retraced lines rule out planes.
  { Set::kTightOnly } -> std::convertible_to<bool>;
};

/// The centre of a box. An uncut reference goes left if its centre is less than the plane.
inline float centre_of(const Box& box, int axis) { return 0.5f * box.lo[axis] + 0.5f * box.hi[axis]; }

/// The box around all references.
inline Box hull(Refs refs) {
  BoxX4 all = BoxX4::empty();
  for (const BuildRef& ref : refs) all.grow(BoxX4::load(ref.box));
  return all.box();
}

/// The order of object splits: by centre, then by primitive and piece, then by box. Rounding can leave a piece empty,
/// and the next piece then has the same s0. References that still compare equal are the same, so any sort gives the
/// same children.
struct ByCentre {
  int axis;
  bool operator()(const BuildRef& a, const BuildRef& b) const {
    const double ca = a.twice_centre(axis), cb = b.twice_centre(axis);
    if (ca != cb) return ca < cb;
    const auto rest = [](const BuildRef& of) {
      return std::tie(of.ref.prim, of.ref.s0, of.ref.s1, of.box.lo, of.box.hi);
    };
    return rest(a) < rest(b);
  }
};

/// Evaluate one plane, by visiting every reference.
template <Primitives P>
Candidate evaluate_plane(const P& prims, Refs refs, const Box& box, BoxRule rule, int axis, float plane) {
  const auto [low, high] = halves(box, axis, plane);
  Candidate split{Candidate::Kind::plane, axis, plane, 0, 0, low, high};
  if (rule == BoxRule::tight) split.left = split.right = Box::empty();
  const auto add_left = [&](const Box& part) {
    ++split.n_left;
    if (rule == BoxRule::tight) split.left.grow(part);
  };
  const auto add_right = [&](const Box& part) {
    ++split.n_right;
    if (rule == BoxRule::tight) split.right.grow(part);
  };
  for (const BuildRef& ref : refs) switch (side_of(ref.box, axis, plane)) {
      case Side::left:
        add_left(ref.box);
        break;
      case Side::right:
        add_right(ref.box);
        break;
      case Side::both: {
        BuildRef l = ref, r = ref;
        cut(prims, axis, plane, l, r);
        add_left(l.box);
        add_right(r.box);
      }
    }
  return split;
}

/// Whether a candidate is a split. With tight boxes, an empty child would leave the other one equal to its parent. With
/// cut boxes, an empty child is empty space.
inline bool divides(const Candidate& split, BoxRule rule) {
  return rule == BoxRule::cut || (split.n_left > 0 && split.n_right > 0);
}

}  // namespace fastlines
