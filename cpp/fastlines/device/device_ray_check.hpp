// Checks whether a ray is valid, as src/fastlines/query/rays.py does for rays in the memory of the host.
#pragma once

#include "../rays/ray.hpp"
#include "records.hpp"

namespace fastlines {

/// The largest float.
inline constexpr float kLargestFloat = 0x1.fffffep127f;

inline bool is_finite(float x) { return abs(x) <= kLargestFloat; }

/// Whether origin, direction, radius and spread are finite and in range, the bounds are in order, and the direction is
/// long enough for t to be a float in the scene.
inline bool is_valid(const RayQuery& ray, const DeviceLimits& limits) {
  bool valid = ray.radius >= 0.0f && double(ray.radius) <= limits.largest_radius && ray.t_min <= ray.t_max &&
               ray.t_min <= kLargestFloat && ray.spread >= 0.0f && ray.spread <= kMaxSpread;
  double to_corner2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    valid = valid && is_finite(ray.origin[k]) && is_finite(ray.direction[k]);
    const double from = ray.origin[k];
    const double to_low = std::fabs(limits.low[k] - from), to_high = std::fabs(limits.high[k] - from);
    const double farther = to_low < to_high ? to_high : to_low;
    to_corner2 += farther * farther;
  }
  const double length = length_of(ray.direction), to_corner = std::sqrt(to_corner2), radius = ray.radius;
  const bool is_reach_valid = ray.spread == 0.0f || radius + double(ray.spread) * to_corner <= limits.largest_radius;
  return valid && is_reach_valid && length > 0.0 && !(to_corner + radius > length * double(kLargestFloat));
}

}  // namespace fastlines
