// A batch of rays as arrays, as the caller gives them.
#pragma once

#include <cstdint>
#include <span>

#include "ray.hpp"

namespace fastlines {

inline constexpr float kNoSpread[] = {0.0f}, kNoLimit[] = {kInfinity};

/// Rays as arrays. Radius, bounds, spread and limit have one entry per ray, or one for all.
struct RayBatch {
  std::span<const Vec3> origins, directions;
  std::span<const float> radius, t_min, t_max, spread = kNoSpread, limit = kNoLimit;

  std::size_t size() const { return origins.size(); }

  RayQuery operator[](std::size_t i) const {
    return {origins[i],          directions[i],       value_of(t_min, i), value_of(t_max, i),
            value_of(radius, i), value_of(spread, i), value_of(limit, i)};
  }

  /// Whether any ray may have a limit.
  bool has_limit() const { return limit.size() != 1 || limit[0] != kInfinity; }

  /// Prefetch the rays with these ids. Skipping those that share a cache line is slower.
  void prefetch(const std::uint32_t* ids, int n) const {
    for (int i = 0; i < n; ++i) {
      __builtin_prefetch(&origins[ids[i]]);
      __builtin_prefetch(&directions[ids[i]]);
    }
  }

  /// The value of ray i: its own, or the one for all.
  static float value_of(std::span<const float> values, std::size_t i) { return values[values.size() == 1 ? 0 : i]; }
};

/// Whether a query may take long: with many rays, or many pairs of a ray and a reference. Others run on the calling
/// thread.
inline bool may_be_long(std::size_t n_rays, std::size_t n_refs) {
  constexpr std::size_t max_rays = 256, max_pairs = 10'000'000;
  return n_rays > max_rays || n_rays * n_refs > max_pairs;
}

}  // namespace fastlines
