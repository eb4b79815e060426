// The frame of a scene: moved to its centre and scaled by a power of two into [−1, 1]³.
//
// All queries compute in this frame, brute force too, so an answer does not depend on the tree, and its precision
// does not depend on the scene's size or place. Both steps are exact or rounded once.
#pragma once

#include <cmath>

#include "../primitives/segments.hpp"
#include "../references/slack.hpp"

namespace fastlines {

struct Frame {
  Vec3 centre{0, 0, 0};
  float scale = 1.0f;  // a power of two
  float grain = 0.0f;  // how far a piece can reach out of its leaf's box

  Vec3 operator()(const Vec3& point) const { return (point - centre) * scale; }
};

/// The frame of a box. A box of no size keeps the unit of its coordinates.
inline Frame frame_of(const Box& box) {
  Frame frame;
  if (box.is_empty()) return frame;
  double half = 0.0;
  for (int k = 0; k < 3; ++k) {
    frame.centre[k] = float(0.5 * (double(box.lo[k]) + double(box.hi[k])));
    half = std::max({half, double(box.hi[k]) - frame.centre[k], frame.centre[k] - double(box.lo[k])});
  }
  if (half > 0.0) frame.scale = float(std::ldexp(1.0, std::clamp(-std::ilogb(half) - 1, -120, 120)));
  frame.grain = float(2.0 * slack_of(box) * frame.scale);
  return frame;
}

}  // namespace fastlines
