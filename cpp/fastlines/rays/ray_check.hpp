// Checks in one vectorised pass whether a batch of rays is valid. The check is conservative: it may reject valid rays.
//
// Magnitudes of floats are ordered as their bits are, and infinities and NaN come last. So loops compare integers,
// which compilers vectorise.
#pragma once

#include <bit>
#include <mutex>

#include "../parallel/parallel_for.hpp"
#include "digest.hpp"
#include "ray_batch.hpp"

namespace fastlines {

/// Extremes of some rays. The size of a vector is its largest coordinate.
struct RayExtremes {
  /// The bits of the largest origin, and of the largest and the smallest direction.
  std::int32_t far_origin = 0, longest = 0, shortest = std::numeric_limits<std::int32_t>::max();
  float max_radius = 0.0f, max_spread = 0.0f;
  bool valid = true;         ///< whether radii, spreads and bounds are valid
  std::uint64_t digest = 0;  ///< the checksum of all numbers

  void add(const RayExtremes& other) {
    far_origin = std::max(far_origin, other.far_origin);
    longest = std::max(longest, other.longest);
    shortest = std::min(shortest, other.shortest);
    max_radius = max(max_radius, other.max_radius);
    max_spread = max(max_spread, other.max_spread);
    valid &= other.valid;
    digest += other.digest;
  }
};

/// The extremes of rays [begin, end).
inline RayExtremes extremes_of(const RayBatch& rays, std::size_t begin, std::size_t end, float largest_radius) {
  const auto part = [&](auto values) { return values.size() == 1 ? values : values.subspan(begin, end - begin); };
  const auto size = [](const Vec3& v) {
    const auto bits = [](float x) { return std::bit_cast<std::int32_t>(x) & 0x7fff'ffff; };
    return std::max(std::max(bits(v[0]), bits(v[1])), bits(v[2]));
  };
  RayExtremes extremes;
  for (const Vec3& origin : part(rays.origins)) extremes.far_origin = std::max(extremes.far_origin, size(origin));
  for (const Vec3& direction : part(rays.directions)) {
    extremes.longest = std::max(extremes.longest, size(direction));
    extremes.shortest = std::min(extremes.shortest, size(direction));
  }
  for (const float x : part(rays.radius)) {
    extremes.valid &= (x >= 0.0f) & (x <= largest_radius);
    extremes.max_radius = max(extremes.max_radius, x);
  }
  for (const float x : part(rays.spread)) {
    extremes.valid &= (x >= 0.0f) & (x <= kMaxSpread);
    extremes.max_spread = max(extremes.max_spread, x);
  }
  const std::span starts = part(rays.t_min), ends = part(rays.t_max);
  for (std::size_t i = 0; i < std::max(starts.size(), ends.size()); ++i) {
    const float start = RayBatch::value_of(starts, i), end_of_ray = RayBatch::value_of(ends, i);
    extremes.valid &= (start <= end_of_ray) & (start <= std::numeric_limits<float>::max());
  }
  // Each array has a seed of its own, and a value for all rays is part of the first chunk.
  std::uint64_t seed = 0;
  for (const auto& points : {rays.origins, rays.directions})
    extremes.digest += digest_of({points[begin].data(), 3 * (end - begin)}, 3 * begin, seed++);
  for (const auto& values : {rays.radius, rays.t_min, rays.t_max, rays.spread}) {
    if (values.size() > 1 || begin == 0) extremes.digest += digest_of(part(values), begin, seed);
    ++seed;
  }
  return extremes;
}

/// Whether all rays are valid, and their checksum.
struct CheckedRays {
  bool valid;
  std::uint64_t digest;
};

/// Whether all rays are valid: origins, directions and radii are finite, and bounds are in order. Directions must also
/// be long enough for t to be a float32 in a scene whose coordinates go up to `farthest`, and the radius and the spread
/// together must not reach farther there than `largest_radius`. `false` means that each ray has to be checked by
/// itself. The checksum tells later whether the caller has changed the arrays.
inline CheckedRays check_rays(const RayBatch& rays, float largest_radius, float farthest, unsigned n_threads) {
  if (rays.size() == 0) return {true, 0};
  constexpr std::size_t chunk_size = 1 << 14;  // rays
  static_assert(chunk_size % kDigestBlock == 0);
  constexpr double largest = std::numeric_limits<float>::max();
  RayExtremes all;
  std::mutex mutex;
  Progress unwatched;
  // Starting a thread takes as long as checking some hundred thousand rays.
  n_threads = std::clamp(unsigned(rays.size() >> 18), 1u, std::max(1u, n_threads));
  parallel_for_chunks(
      rays.size(), chunk_size, n_threads, unwatched, [] { return 0; },
      [&](int, std::size_t begin, std::size_t end) {
        const RayExtremes extremes = extremes_of(rays, begin, end, largest_radius);
        const std::lock_guard lock(mutex);
        all.add(extremes);
      });
  const auto to_float = [](std::int32_t bits) { return std::bit_cast<float>(std::min(bits, 0x7f80'0000)); };
  const double far_origin = to_float(all.far_origin), shortest = to_float(all.shortest);
  const double distance = 2.0 * (far_origin + farthest), far = distance + all.max_radius;
  const bool valid = all.valid && far_origin <= largest && to_float(all.longest) <= largest && shortest > 0.0 &&
                     far <= shortest * largest &&
                     (all.max_spread == 0.0f || all.max_radius + all.max_spread * distance <= largest_radius);
  return {valid, all.digest};
}

}  // namespace fastlines
