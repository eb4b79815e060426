// Cuts references by a plane.
//
// Only `side_of` decides on which side a reference is, by comparing its box with the plane. So a split set, which
// counts references, and a partition, which moves them, cannot disagree.
#pragma once

#include <span>

#include "build_ref.hpp"

namespace fastlines {

enum class Side : unsigned { left = 1, right = 2, both = left | right };

/// The side of a box; a box that lies in the plane is on the left. Branchless.
inline Side side_of(const Box& box, int axis, float plane) {
  const unsigned on_right = box.hi[axis] > plane;  // NaN counts as left
  const unsigned behind = on_right & unsigned(box.lo[axis] >= plane);
  return Side(on_right << 1 | (behind ^ 1));
}

/// Cut a piece of a curve that straddles the plane x[axis] = plane. On entry both references are the whole piece; on
/// exit they are its left and its right part. Both store the same s, so the parts tile the piece. Neither box leaves
/// the box of the whole piece.
template <Curve C>
void cut_curve(const C& curve, int axis, float plane, BuildRef& left, BuildRef& right) {
  const float s = std::clamp(curve.crossing(axis, plane), left.ref.s0, std::min(left.ref.s1, 1.0f));
  const Vec3 at = curve.point(s);
  const bool rises = curve.ascends(axis);
  (rises ? left : right).ref.s1 = (rises ? right : left).ref.s0 = s;
  for (int k = 0; k < 3; ++k) {
    const float lo = left.box.lo[k], hi = left.box.hi[k], x = std::min(std::max(at[k], lo), hi);
    const bool left_is_low = curve.ascends(k) == rises;  // along axis k
    left.box.lo[k] = left_is_low ? lo : x;
    left.box.hi[k] = left_is_low ? x : hi;
    right.box.lo[k] = left_is_low ? x : lo;
    right.box.hi[k] = left_is_low ? hi : x;
  }
  left.box.hi[axis] = right.box.lo[axis] = plane;
}

/// Cut any reference that straddles a plane. On entry `left` and `right` are copies of it; on exit they are its parts.
/// For primitives other than curves, the box of a part is `clipped_bounds`; if that is empty, the part fills its half
/// of the box.
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

/// Grow the boxes of the bins between planes by the parts of a reference. The planes must be in ascending order, and
/// the reference must straddle all of them. `bins` has one more entry than `planes`.
template <Primitives P>
void grow_bins(const P& prims, const BuildRef& whole, int axis, std::span<const float> planes, Box* bins) {
  if constexpr (Curves<P>) {
    // The box of a part is that of its two ends, and neighbouring parts share an end. The ends of the whole are corners
    // of its box: `from` and `to`, in the direction of the axis.
    const auto curve = prims.curve(whole.ref.prim);  // a copy, to avoid aliasing with the bins
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
