// The parts of directions along the axis of a line and across it.
#pragma once

#include "../simd/lanes.hpp"

namespace fastlines {

/// The sine and the cosine of the angle between directions and the planes across unit axes, and their unit parts
/// across.
struct Across {
  FloatLanes sine, cosine;
  Vec3Lanes across;

  Across(const Vec3Lanes& axes, const Vec3Lanes& directions)
      : sine(clamp(dot(directions, axes), -1.0f, 1.0f)),
        cosine(sqrt(max(1.0f - sine * sine, FloatLanes(0.0f)))),
        across(unit(directions - sine * axes)) {}
};

}  // namespace fastlines
