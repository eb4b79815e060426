// The slack: how far a piece may extend beyond the boxes of the nodes that list it.
//
// A cut stores the plane as a side of both boxes, and the s of the crossing (references/cut.hpp). Let m be the scene's
// largest coordinate and l its longest side. Two roundings occur:
//
//     s is rounded to float32, by at most 2⁻²⁵ for s < 1: the point moves by at most 2⁻²⁵·l.
//     The point is rounded to float32, by at most half an ulp: 2⁻²⁴·m, or 2⁻¹⁵⁰ for subnormal numbers.
//
// So the float32 end of a piece, `Segment::point`, lies within 2⁻²⁵·l + 2⁻²⁴·m + 2⁻¹⁵⁰ of its box. The slack is no less
// than that, and a usable tree exceeds it nowhere (tree/usable.hpp). The exact point differs from its float32 value by
// half an ulp, which is no more than the slack. So a search that grows boxes by twice the slack (`Frame::overhang`)
// loses nothing.
#pragma once

#include <cmath>

#include "../math/box.hpp"

namespace fastlines {

/// The slack of a scene with this box, in units of the scene.
inline double slack_of(const Box& scene) {
  double largest = 0.0;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::abs(double(scene.lo[k])), std::abs(double(scene.hi[k]))});
  return std::ldexp(largest + scene.side(scene.longest_axis()), -24) + std::ldexp(1.0, -150);
}

}  // namespace fastlines
