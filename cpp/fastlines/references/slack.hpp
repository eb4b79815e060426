// How far a piece may reach out of the boxes of the nodes that list it.
//
// A cut keeps the plane as a side of both boxes, and the s of the crossing (references/cut.hpp). With m = the scene's
// largest coordinate and l = its longest side,
//
//     s is rounded to float32, by at most 2⁻²⁵ for s < 1: the point moves by at most 2⁻²⁵·l,
//     the point is rounded to float32: by at most half an ulp, 2⁻²⁴·m, or 2⁻¹⁵⁰ where numbers are subnormal.
//
// So the float32 end of a piece, `Segment::point`, lies within 2⁻²⁵·l + 2⁻²⁴·m + 2⁻¹⁵⁰ of what its box says. Trees may
// be off by the slack, which is no less, and not by more (tree/usable.hpp). The point itself is off by half an ulp,
// which is no more than the slack: a search that looks twice the slack beyond a box loses nothing (`Frame::grain`).
#pragma once

#include <cmath>

#include "../math/box.hpp"

namespace fastlines {

/// In the units of the scene, of which this is the box.
inline double slack_of(const Box& scene) {
  double largest = 0.0;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::abs(double(scene.lo[k])), std::abs(double(scene.hi[k]))});
  return std::ldexp(largest + scene.side(scene.longest_axis()), -24) + std::ldexp(1.0, -150);
}

}  // namespace fastlines
