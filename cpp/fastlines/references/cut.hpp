// Cutting references by a plane.
//
// Which side a reference falls on is decided by comparing its box with the plane, here and nowhere else, so
// that a split set which counts and a partition which moves can not disagree.
#pragma once

#include <span>
#include <utility>

#include "reference.hpp"

namespace fastlines {

enum class Side : unsigned { left = 1, right = 2, both = left | right };

/// A reference that lies in the plane goes left. Nothing branches.
inline Side side_of(const Box& box, int axis, float plane) {
  const unsigned on_right = box.hi[axis] > plane;  // no number counts as left
  const unsigned behind = on_right & unsigned(box.lo[axis] >= plane);
  return Side(on_right << 1 | (behind ^ 1));
}

/// Cut the piece of a curve that straddles the plane x[axis] = plane into its left and its right part: both are the
/// whole before. Both store the same s, so the pieces tile; neither box leaves the box of the whole.
template <Curve C>
void cut_curve(const C& curve, int axis, float plane, BuildRef& left, BuildRef& right) {
  const float s = std::clamp(curve.crossing(axis, plane), left.ref.s0, std::min(left.ref.s1, 1.0f));
  const Vec3 at = curve.point(s);
  const bool rises = curve.ascends(axis);
  (rises ? left : right).ref.s1 = (rises ? right : left).ref.s0 = s;
  for (int k = 0; k < 3; ++k) {
    const float lo = left.box.lo[k], hi = left.box.hi[k], x = std::min(std::max(at[k], lo), hi);
    const bool along = curve.ascends(k) == rises;  // the left part is the one before
    left.box.lo[k] = along ? lo : x;
    left.box.hi[k] = along ? x : hi;
    right.box.lo[k] = along ? x : lo;
    right.box.hi[k] = along ? hi : x;
  }
  left.box.hi[axis] = right.box.lo[axis] = plane;
}

/// Cut any reference that straddles a plane, of which there are two copies, into its two parts. A primitive that is no
/// curve is asked for its clipped bounds; where it knows no better, the part fills its half of the box.
template <Primitives P>
void cut(const P& prims, int axis, float plane, BuildRef& left, BuildRef& right) {
  if constexpr (Curves<P>) {
    cut_curve(prims.curve(left.ref.prim), axis, plane, left, right);
  } else {
    left.box.hi[axis] = right.box.lo[axis] = plane;
    for (BuildRef* part : {&left, &right}) {
      const Box clipped = prims.clipped_bounds(part->ref.prim, part->box);
      if (!clipped.is_empty()) part->box = clipped;
    }
  }
}

/// The planes, rising, all straddled by a reference, divide space into bins. Grow the box of each bin by the box of the
/// part in it; bins has one more entry than planes.
template <Primitives P>
void grow_bins(const P& prims, const BuildRef& whole, int axis, std::span<const float> planes, Box* bins) {
  if constexpr (Curves<P>) {
    // The box of a part is that of its two ends, and two parts share the point between them. The ends of the whole are
    // corners of its box: the one that the curve comes from in the direction of the axis, and the one it goes to.
    const auto curve = prims.curve(whole.ref.prim);  // a copy, so that nothing written can alias it
    const float s0 = whole.ref.s0, s1 = std::min(whole.ref.s1, 1.0f);
    const Vec3 lo = whole.box.lo, hi = whole.box.hi;
    Vec3 from, to;
    for (int k = 0; k < 3; ++k) {
      const bool along = curve.ascends(k) == curve.ascends(axis);
      from[k] = along ? lo[k] : hi[k];
      to[k] = along ? hi[k] : lo[k];
    }
    bins[0].grow(from);
    for (std::size_t i = 0; i < planes.size(); ++i) {
      Vec3 at = curve.point(std::clamp(curve.crossing(axis, planes[i]), s0, s1));
      for (int k = 0; k < 3; ++k) at[k] = std::min(std::max(at[k], lo[k]), hi[k]);
      at[axis] = planes[i];
      bins[i].grow(at);
      bins[i + 1].grow(at);
    }
    bins[planes.size()].grow(to);
  } else {
    BuildRef rest = whole;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      BuildRef left = rest;
      cut(prims, axis, planes[i], left, rest);
      bins[i].grow(left.box);
    }
    bins[planes.size()].grow(rest.box);
  }
}

}  // namespace fastlines
