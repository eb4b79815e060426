// A candidate: one way to divide a node, with what its cost needs to know.
//
// A split set (the thesis's SPLITS) is anything that shows its candidates for a node to a visitor:
//
//     set.visit(prims, refs, box, rule, [](const Candidate&) { … });
//
// It counts; it moves nothing. `partition` carries a candidate out.
#pragma once

#include <algorithm>
#include <cassert>
#include <span>
#include <vector>

#include "../primitives/segments.hpp"
#include "../references/cut.hpp"
#include "../simd/box_x4.hpp"
#include "box_rule.hpp"
#include "measure.hpp"

namespace fastlines {

struct Candidate {
  enum class Kind { objects, centres, plane } kind;
  int axis;
  float plane;         // of a plane: references that straddle it are cut
  std::size_t n_left;  // of objects: that many go left, in the order of their centres
  std::size_t n_right;
  Box left, right;

  /// What its children cost as leaves, times the area of their parent.
  double sah(const Measure& measure) const {
    return measure.area(left) * measure.tests(n_left) + measure.area(right) * measure.tests(n_right);
  }
};

using Refs = std::span<const BuildRef>;

/// Of a box that goes whole to one side of a plane: left if this is less.
inline float centre_of(const Box& box, int axis) { return 0.5f * box.lo[axis] + 0.5f * box.hi[axis]; }

inline Box hull(Refs refs) {
  BoxX4 all = BoxX4::empty();
  for (const BuildRef& ref : refs) all.grow(BoxX4::load(ref.box));
  return all.box();
}

/// The order of object splits: by centre; ties by primitive and piece, so that it is total.
struct ByCentre {
  int axis;
  bool operator()(const BuildRef& a, const BuildRef& b) const {
    const double ca = a.centre(axis), cb = b.centre(axis);
    if (ca != cb) return ca < cb;
    if (a.ref.prim != b.ref.prim) return a.ref.prim < b.ref.prim;
    return a.ref.s0 < b.ref.s0;
  }
};

/// One plane, counted the plain way: by looking at every reference.
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

/// A tight child without references would leave the other as its parent was: no split. A cut one is empty space.
inline bool divides(const Candidate& split, BoxRule rule) {
  return rule == BoxRule::cut || (split.n_left > 0 && split.n_right > 0);
}

}  // namespace fastlines
