// Tests a ray against boxes and against the planes of a KD tree, by slabs.
#pragma once

#include <algorithm>
#include <cmath>

#include "../math/box.hpp"
#include "../rays/ray.hpp"

namespace fastlines {

/// A conservative box test: boxes and planes are grown by the radius and by a bound on rounding.
class Slabs {
 public:
  /// Boxes are grown by the radius of the ray and by `prim_radius`, which is in units of the scene.
  Slabs(const Ray& ray, const Frame& frame, float prim_radius = 0.0f) : frame_(frame), t_min_(ray.t_min) {
    const float grow = ray.radius + ray.eps + prim_radius * frame.scale;
    for (int k = 0; k < 3; ++k) {
      const float r = std::copysign(std::max(std::abs(ray.r[k]), 1e-18f), ray.r[k]);
      inverse_[k] = 1.0f / r;
      backwards_[k] = r < 0.0f;
      near_[k] = ray.o[k] + (backwards_[k] ? -grow : grow);
      far_[k] = ray.o[k] + (backwards_[k] ? grow : -grow);
    }
  }

  /// An interval of t in the frame; empty if t_enter > t_leave.
  struct Interval {
    float t_enter, t_leave;
  };

  /// The interval, up to the limit, in which the ray is inside the grown box.
  Interval clip(const Box& box, float limit) const {
    Interval inside{t_min_, limit};
    for (int k = 0; k < 3; ++k) {
      const float lo = in_frame(frame_, k, box.lo[k]), hi = in_frame(frame_, k, box.hi[k]);
      inside.t_enter = std::max(inside.t_enter, enter_beyond(k, backwards_[k] ? hi : lo));
      inside.t_leave = std::min(inside.t_leave, leave_before(k, backwards_[k] ? lo : hi));
    }
    return inside;
  }

  /// The t at which the ray enters the box; ∞ if it misses the box or enters it beyond the limit.
  float enter(const Box& box, float limit) const {
    const Interval inside = clip(box, limit);
    return inside.t_enter <= inside.t_leave ? inside.t_enter : kInfinity;
  }

  /// The t at which the ray enters the half-space beyond a plane of the frame, and leaves the one before it, both
  /// grown.
  float enter_beyond(int axis, float plane) const { return (plane - near_[axis]) * inverse_[axis]; }
  float leave_before(int axis, float plane) const { return (plane - far_[axis]) * inverse_[axis]; }

  bool is_backwards(int axis) const { return backwards_[axis]; }

  /// A coordinate of a box in the frame, rounded as `clip` rounds it.
  static float in_frame(const Frame& frame, int axis, float x) { return (x - frame.centre[axis]) * frame.scale; }

 private:
  Frame frame_;
  float t_min_;
  Vec3 inverse_, near_, far_;
  bool backwards_[3];
};

}  // namespace fastlines
