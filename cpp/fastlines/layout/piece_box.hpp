// The box of a piece: of what a reference stands for in the box of its leaf.
#pragma once

#include <algorithm>

#include "../primitives/ray_primitive.hpp"
#include "../references/reference.hpp"

namespace fastlines {

/// The box around the piece of an axis, or around the part of another primitive in the box of a leaf.
template <RayPrimitive P>
Box box_of_piece(const P& prims, const Reference& ref, const Box& leaf) {
  if constexpr (AxisPrimitive<P>) {
    const Segment& axis = prims.curve(ref.prim);
    return Segment{axis.point(ref.s0), axis.point(std::min(ref.s1, 1.0f))}.bounds();
  } else {
    // A cut keeps a part that rounding makes empty (references/cut.hpp); it may be anywhere in the leaf.
    const Box part = prims.clipped_bounds(ref.prim, leaf);
    return part.is_empty() ? leaf : part;
  }
}

}  // namespace fastlines
