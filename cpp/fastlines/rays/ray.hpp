// A ray, prepared for a scene's frame.
//
// The caller's ray is o + t·d for t in [t_min, t_max]. The prepared one starts at the point of the line that is nearest
// to the scene's centre, so that the numbers stay small wherever the caller's origin is: with |d| = L, r = d/L and
// t0 = (centre − o)·r (in double),
//
//     o' = (o − centre + t0·r)·scale,      t' = (t·L − t0)·scale,      t = (t0 + t'/scale)/L.
//
// u and v complete r to an orthonormal basis (Duff et al. 2017, "Building an orthonormal basis, revisited").
#pragma once

#include "../simd/float_x16.hpp"
#include "frame.hpp"

namespace fastlines {

struct RayQuery {
  Vec3 origin, direction;
  float t_min, t_max, radius;
};

/// The way back from the frame: t as the caller counts it.
inline float to_ray_t(float t, float t_min, float t_max, float t_min_ray, float t_max_ray, double t0, double inv_scale,
                      double inv_length) {
  const float back = min(max(float((t0 + double(t) * inv_scale) * inv_length), t_min_ray), t_max_ray);
  return t == t_min ? t_min_ray : t == t_max ? t_max_ray : back;
}

struct Ray {
  Vec3 o, r, u, v;                   // in the frame; r, u, v orthonormal
  float t_min, t_max;                // in the frame
  float radius, radius2;             // in the frame
  float eps;                         // covers the rounding of the exact test and of the boxes
  float tie_tolerance;               // t that lie farther apart than this stay apart as the caller counts them
  double t0, inv_scale, inv_length;  // the way back
  float t_min_ray, t_max_ray;

  /// t as the caller counts it.
  float t_ray(float t) const { return to_ray_t(t, t_min, t_max, t_min_ray, t_max_ray, t0, inv_scale, inv_length); }

  /// A bound on all t in the frame that the caller counts as no more than this.
  float beyond(float t_ray) const {
    return std::min(t_max, float((double(t_ray) / inv_length - t0) / inv_scale) + 2.0f * tie_tolerance);
  }
};

/// Bound on what the frame's coordinates are clamped to; squares of it are finite.
inline constexpr float kFar = 1e18f;

inline double length_of(const Vec3& direction) {
  const double x = direction[0], y = direction[1], z = direction[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// One text for one ray and, in a loop that the compiler turns into vectors, for many: so nothing here branches. For
/// what `askable.hpp` does not let pass nothing is promised. The direction is `length` long, as `length_of` has it, and
/// `inv_length` is 1/length: from others come other bits.
[[gnu::always_inline]] inline Ray prepare(const RayQuery& query, double length, double inv_length, const Frame& frame) {
  // Written so that the compiler takes two instructions for a vector, not six.
  const auto clamped = [](double x) { return std::copysign(min(std::fabs(float(x)), kFar), float(x)); };
  Ray ray;
  double from_centre[3], d[3];
  for (int k = 0; k < 3; ++k) {
    d[k] = query.direction[k];
    from_centre[k] = double(query.origin[k]) - double(frame.centre[k]);
  }
  const double scale = frame.scale;
  ray.inv_length = inv_length;
  ray.inv_scale = 1.0 / scale;
  for (int k = 0; k < 3; ++k) d[k] *= ray.inv_length;
  ray.t0 = -(from_centre[0] * d[0] + from_centre[1] * d[1] + from_centre[2] * d[2]);
  for (int k = 0; k < 3; ++k) {
    ray.o[k] = clamped((from_centre[k] + ray.t0 * d[k]) * scale);
    ray.r[k] = float(d[k]);
  }
  const float largest = max(max(std::fabs(ray.o[0]), std::fabs(ray.o[1])), std::fabs(ray.o[2]));

  const float sign = std::copysign(1.0f, ray.r[2]);
  const float a = -1.0f / (sign + ray.r[2]);
  const float b = ray.r[0] * ray.r[1] * a;
  ray.u = {1.0f + sign * ray.r[0] * ray.r[0] * a, sign * b, -sign * ray.r[0]};
  ray.v = {b, sign + ray.r[1] * ray.r[1] * a, -ray.r[1]};

  ray.t_min_ray = query.t_min;
  ray.t_max_ray = query.t_max;
  ray.t_min = clamped((double(query.t_min) * length - ray.t0) * scale);
  ray.t_max = clamped((double(query.t_max) * length - ray.t0) * scale);
  ray.radius = clamped(double(query.radius) * scale);
  ray.radius2 = ray.radius * ray.radius;
  ray.eps = (3.0f + largest + ray.radius) * 0x1p-20f + frame.grain;
  const double rounding = std::fabs(ray.t0) * scale + 4.0 + 2.0 * ray.radius;
  ray.tie_tolerance = ray.eps + clamped(rounding * 0x1p-22 + length * scale * 0x1p-146);
  return ray;
}

inline Ray prepare(const RayQuery& query, const Frame& frame) {
  const double length = length_of(query.direction);
  return prepare(query, length, 1.0 / length, frame);
}

}  // namespace fastlines
