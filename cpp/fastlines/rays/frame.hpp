// The frame of a scene: coordinates relative to its centre, scaled by a power of two into [−1, 1]³.
//
// All queries, brute force too, compute in this frame. So an answer does not depend on the tree, and its precision does
// not depend on the scene's size or place. The subtraction is rounded once; the scaling is exact.
#pragma once

#include <cmath>

#include "../math/box.hpp"
#include "../references/slack.hpp"

namespace fastlines {

struct Frame {
  Vec3 centre{0, 0, 0};
  float scale = 1.0f;  ///< a power of two
  /// How far a hit can lie outside the grown box of its leaf, in the frame: twice the slack, and the rounding that
  /// grows with the radius of a primitive.
  float overhang = 0.0f;

  /// A point in the frame.
  Vec3 operator()(const Vec3& point) const { return (point - centre) * scale; }
};

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
