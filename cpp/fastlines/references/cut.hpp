// Cutting references by a plane.
//
// Which side a reference falls on is decided by comparing its box with the plane, here and nowhere else, so
// that a split set which counts and a partition which moves can not disagree.
#pragma once

#include <utility>

#include "reference.hpp"

namespace fastlines {

enum class Side { left, right, both };

/// A reference that lies in the plane goes left.
inline Side side_of(const Box& box, int axis, float plane) {
  if (box.hi[axis] <= plane) return Side::left;
  if (box.lo[axis] >= plane) return Side::right;
  return Side::both;
}

/// Cut a reference that straddles the plane x[axis] = plane into its left and its right part.
template <Primitives P>
std::pair<BuildRef, BuildRef> cut(const P& prims, const BuildRef& whole, int axis, float plane) {
  BuildRef left = whole, right = whole;
  if constexpr (Curves<P>) {
    // Both parts store the same s, so the pieces tile; neither box leaves the box of the whole.
    const Reference& ref = whole.ref;
    const float s = std::clamp(prims.crossing(ref.prim, axis, plane), ref.s0, std::min(ref.s1, 1.0f));
    const Vec3 at = prims.point(ref.prim, s);
    const bool ascends = prims.ascends(ref.prim, axis);
    BuildRef& before = ascends ? left : right;
    BuildRef& after = ascends ? right : left;
    before.ref.s1 = after.ref.s0 = s;
    for (int k = 0; k < 3; ++k) {
      const float x = std::clamp(at[k], whole.box.lo[k], whole.box.hi[k]);
      const bool up = prims.ascends(ref.prim, k);
      (up ? before.box.hi : before.box.lo)[k] = x;
      (up ? after.box.lo : after.box.hi)[k] = x;
    }
  } else {
    // Ask the primitive; where it knows no better, the part fills its half of the box.
    Box half = whole.box;
    half.hi[axis] = plane;
    left.box = prims.clipped_bounds(whole.ref.prim, half);
    if (left.box.is_empty()) left.box = half;
    half = whole.box;
    half.lo[axis] = plane;
    right.box = prims.clipped_bounds(whole.ref.prim, half);
    if (right.box.is_empty()) right.box = half;
  }
  left.box.hi[axis] = right.box.lo[axis] = plane;
  return {left, right};
}

}  // namespace fastlines
