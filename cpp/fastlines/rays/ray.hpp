// A ray, prepared for a scene's frame.
//
// The caller's ray is o + t·d for t in [t_min, t_max]. The prepared ray starts at the point of its line that is nearest
// to the scene's centre, so that numbers stay small wherever the caller's origin is. With |d| = L, r = d/L and t0 =
// (centre − o)·r, in double,
//
//     o' = (o − centre + t0·r)·scale,      t' = (t·L − t0)·scale,      t = (t0 + t'/scale)/L.
//
// u and v complete r to an orthonormal basis (Duff et al. 2017, "Building an orthonormal basis, revisited").
#pragma once

#include <algorithm>
#include <cmath>

#include "../simd/float_x1.hpp"
#include "frame.hpp"

namespace fastlines {

/// The largest spread of a ray: its square is finite, with room to spare.
inline constexpr float kMaxSpread = 1e12f;

/// A ray as the caller gives it. t is in units of the direction's length.
struct RayQuery {
  Vec3 origin, direction;
  float t_min, t_max, radius;
  float spread = 0.0f;  ///< only `prepare_for` of primitives with a spread reads it
  /// Hits with a larger t need not be found, but may be. Unlike t_max it clips nothing; only `prepare_for` reads it.
  float limit = kInfinity;
};

/// Convert t from the frame to units of the caller's ray. Bounds map to bounds exactly.
inline float to_ray_t(float t, float t_min, float t_max, float t_min_ray, float t_max_ray, double t0, double inv_scale,
                      double inv_length) {
  const float inside = min(max(float((t0 + double(t) * inv_scale) * inv_length), t_min_ray), t_max_ray);
  return t == t_min ? t_min_ray : t == t_max ? t_max_ray : inside;
}

/// An upper bound on all t in the frame that are at most `t_ray` in units of the caller's ray, and at most t_max.
inline float max_t_of(float t_ray, float t_max, float tie_tolerance, double t0, double inv_scale, double inv_length) {
  return std::min(t_max, float((double(t_ray) / inv_length - t0) / inv_scale) + 2.0f * tie_tolerance);
}

/// A ray prepared for a frame.
struct Ray {
  Vec3 o, r, u, v;        ///< in the frame; r, u, v orthonormal
  float t_min, t_max;     ///< in the frame
  float limit;            ///< in the frame: hits beyond it need not be found; t_max, or less
  float radius, radius2;  ///< in the frame; radius2 = radius²
  float eps;              ///< in the frame: covers the rounding of the exact test and of the boxes
  float tie_tolerance;    ///< two t in the frame that differ by more keep their order in units of the caller's ray
  double t0, inv_scale, inv_length;  ///< for the conversion to units of the caller's ray
  float t_min_ray, t_max_ray;

  /// t in units of the caller's ray.
  float t_ray(float t) const { return to_ray_t(t, t_min, t_max, t_min_ray, t_max_ray, t0, inv_scale, inv_length); }

  /// The distance in units of the scene, from its square in the frame.
  float distance(float dist2) const { return float(std::sqrt(dist2) * inv_scale); }

  /// An upper bound on all t in the frame that are at most `t_ray` in units of the caller's ray.
  float max_t(float t_ray) const { return max_t_of(t_ray, t_max, tie_tolerance, t0, inv_scale, inv_length); }
};

/// Coordinates and t in the frame are clamped to ± this, whose square is finite.
inline constexpr float kMaxCoordinate = 1e18f;

inline double length_of(const Vec3& direction) {
  const double x = direction[0], y = direction[1], z = direction[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// Prepare a ray. Branchless, so that compilers vectorise a loop over it; the same definition serves one ray and many.
/// Preconditions: the ray is valid (rays/ray_check.hpp), `length` is that of `length_of`, and `inv_length` is exactly
/// 1.0 / length.
[[gnu::always_inline]] inline Ray prepare(const RayQuery& query, double length, double inv_length, const Frame& frame) {
  // In this form the compiler uses two vector instructions instead of six.
  const auto clamped = [](double x) { return std::copysign(min(std::fabs(float(x)), kMaxCoordinate), float(x)); };
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
  ray.limit = ray.t_max;
  ray.radius = clamped(double(query.radius) * scale);
  ray.radius2 = ray.radius * ray.radius;
  ray.eps = (3.0f + largest + ray.radius) * 0x1p-20f + frame.overhang;
  const double rounding = std::fabs(ray.t0) * scale + 4.0 + 2.0 * ray.radius;
  ray.tie_tolerance = ray.eps + clamped(rounding * 0x1p-22 + length * scale * 0x1p-146);
  return ray;
}

inline Ray prepare(const RayQuery& query, const Frame& frame) {
  const double length = length_of(query.direction);
  return prepare(query, length, 1.0 / length, frame);
}

}  // namespace fastlines
