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

#include "frame.hpp"

namespace fastlines {

struct RayQuery {
  Vec3 origin, direction;
  float t_min, t_max, radius;
};

struct Ray {
  Vec3 o, r, u, v;           // in the frame; r, u, v orthonormal
  float t_min, t_max;        // in the frame
  float radius, radius2;     // in the frame
  float eps;                 // covers the rounding of the exact test and of the boxes
  double t0, length, scale;  // the way back
  float t_min_given, t_max_given;

  /// t as the caller counts it.
  float t_given(float t) const {
    if (t == t_min) return t_min_given;
    if (t == t_max) return t_max_given;
    const auto given = float((t0 + double(t) / scale) / length);
    return std::min(std::max(given, t_min_given), t_max_given);
  }

  /// A bound on all t in the frame that become, rounded, no more than the caller's t of this one.
  float not_beyond(float t, float given) const {
    return float(t + eps + std::ldexp(std::abs(double(given)) * length * scale, -22));
  }
};

/// Bound on what the frame's coordinates are clamped to; squares of it are finite.
inline constexpr double kFar = 1e18;

inline Ray prepare(const RayQuery& query, const Frame& frame) {
  Ray ray;
  double from_centre[3], d[3], length2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    d[k] = query.direction[k];
    length2 += d[k] * d[k];
    from_centre[k] = double(query.origin[k]) - frame.centre[k];
  }
  ray.length = std::sqrt(length2);
  ray.scale = frame.scale;
  for (int k = 0; k < 3; ++k) d[k] /= ray.length;
  ray.t0 = -(from_centre[0] * d[0] + from_centre[1] * d[1] + from_centre[2] * d[2]);
  float largest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    ray.o[k] = float(std::clamp((from_centre[k] + ray.t0 * d[k]) * ray.scale, -kFar, kFar));
    ray.r[k] = float(d[k]);
    largest = std::max(largest, std::abs(ray.o[k]));
  }

  const float sign = std::copysign(1.0f, ray.r[2]);
  const float a = -1.0f / (sign + ray.r[2]);
  const float b = ray.r[0] * ray.r[1] * a;
  ray.u = {1.0f + sign * ray.r[0] * ray.r[0] * a, sign * b, -sign * ray.r[0]};
  ray.v = {b, sign + ray.r[1] * ray.r[1] * a, -ray.r[1]};

  const auto to_frame = [&](float t) {
    return float(std::clamp((double(t) * ray.length - ray.t0) * ray.scale, -kFar, kFar));
  };
  ray.t_min_given = query.t_min;
  ray.t_max_given = query.t_max;
  ray.t_min = to_frame(query.t_min);
  ray.t_max = to_frame(query.t_max);
  ray.radius = float(std::min(double(query.radius) * ray.scale, kFar));
  ray.radius2 = ray.radius * ray.radius;
  ray.eps = std::ldexp(2.0f + largest + ray.radius, -20) + frame.grain;
  return ray;
}

}  // namespace fastlines
