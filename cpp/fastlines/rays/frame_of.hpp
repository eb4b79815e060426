// The frame of a scene, from its box. The tree of a part of the scene may compute in the same frame: a larger box has a
// larger overhang, in units of the scene, so its searches lose nothing.
#pragma once

#include <cmath>

#include "../math/box.hpp"
#include "../references/slack.hpp"
#include "frame.hpp"

namespace fastlines {

/// The frame of a box. A box of size zero keeps the unit of its coordinates (scale = 1).
inline Frame frame_of(const Box& box) {
  Frame frame;
  if (box.is_empty()) return frame;
  double half = 0.0;
  for (int k = 0; k < 3; ++k) {
    frame.centre[k] = float(0.5 * (double(box.lo[k]) + double(box.hi[k])));
    half = std::max({half, double(box.hi[k]) - frame.centre[k], frame.centre[k] - double(box.lo[k])});
  }
  if (half > 0.0) frame.scale = float(std::ldexp(1.0, std::clamp(-std::ilogb(half) - 1, -120, 120)));
  frame.overhang = float(2.0 * slack_of(box) * frame.scale);
  return frame;
}

/// A bound on the rounding in the exact test of a primitive, as a fraction of its radius.
inline constexpr float kRadiusRounding = 0x1p-19f;

/// The frame of a box around the axes of primitives with radii up to `max_radius`.
inline Frame frame_of(const Box& box, float max_radius) {
  Frame frame = frame_of(box);
  frame.overhang += max_radius * frame.scale * kRadiusRounding;
  return frame;
}

}  // namespace fastlines
