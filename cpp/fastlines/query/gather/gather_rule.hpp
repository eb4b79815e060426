// What a gather sums for each ray: over its hits,
//
//     value · K(D; R) / sin θ · exp(−σ·t·|d|) · exp(−λ·u·l) · p(cos φ).
//
// D is the distance of the hit, R its reach, θ the angle between ray and line, t·|d| the length along the ray from its
// origin, u·l the length along the line from its first point, and φ the angle between the light, which flies along the
// line, and its way back to the ray's origin.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "../../rays/ray.hpp"

namespace fastlines {

/// The kernel K: 0, a box 1/(2R), or Epanechnikov's 3/(4R)·(1 − (D/R)²). With `none`, K / sin θ is 1.
enum class Blur { none, box, epanechnikov };

/// The most numbers that a primitive has for a sum.
inline constexpr int kMaxChannels = 8;

/// The least sin θ that float32 can tell from 0. Pairs with a smaller one are left out, unless the blur is `none`.
inline constexpr float kLeastSine = 0x1p-20f;

/// The least R·sin θ, below which the inverse may be infinite. Pairs with a smaller one are left out, unless the blur
/// is `none`.
inline constexpr float kLeastWidth = 0x1p-126f;

/// What is summed. The numbers are finite, and the absolute value of the phase is less than 1.
struct GatherRule {
  Blur blur = Blur::box;
  int n_channels = 1;
  std::array<float, kMaxChannels> sigma{};       ///< σ of each channel, per length along the ray
  std::array<float, kMaxChannels> line_sigma{};  ///< λ of each channel, per length along the line
  std::optional<float> phase;                    ///< g of Henyey and Greenstein's function; without it p is 1
  bool inner = true;  ///< whether hits are left out whose t is a bound of the ray, or that are at an end of a line
  std::span<const float> values;  ///< n_channels for each primitive; empty for ones
  /// Optical depths at n_depths ≥ 2 equal steps from t_min to t_max of each ray, which stand for σ·t·|d|. Each has
  /// n_depth_channels numbers: one for all channels, or one for each.
  std::span<const float> depths;
  int n_depths = 0, n_depth_channels = 1;
};

/// A ray as contributions read it.
struct GatherRay {
  float direction[3];  ///< of length 1, computed in float64 and rounded once
  float length;        ///< of the caller's direction
  float t_min, t_max, radius, spread;
  const float* depths = nullptr;

  /// Ray i of its batch.
  GatherRay(const RayQuery& query, std::size_t i, const GatherRule& rule)
      : t_min(query.t_min), t_max(query.t_max), radius(query.radius), spread(query.spread) {
    const double exact = length_of(query.direction), inv_length = 1.0 / exact;
    length = float(exact);
    for (int k = 0; k < 3; ++k) direction[k] = float(query.direction[k] * inv_length);
    if (rule.n_depths)
      depths = rule.depths.data() + i * std::size_t(rule.n_depths) * std::size_t(rule.n_depth_channels);
  }
};

/// Lines as rows of numbers: both ends, and in rows of eight the radius at each.
struct GatherLines {
  const float* rows;
  std::size_t n_numbers;  ///< 6 or 8
};

/// Hits of a ray as columns, in units of the caller's ray.
struct GatherHits {
  const float *t, *u, *distance;
  const std::uint32_t* prim;  ///< whose value counts
  const std::uint32_t* line;  ///< the row of `GatherLines`
  std::size_t n;
};

}  // namespace fastlines
