// Sums over all hits of rays: what is summed, and the sums.
#pragma once

#include <array>
#include <optional>

#include "ray.hpp"

namespace fl {

/// The kernel K that spreads a hit over the reach R of its ray: the radius of the query and of the line together.
enum class Blur {
  none,          ///< No kernel: K / sin θ is 1.
  box,           ///< 1 / (2R).
  epanechnikov,  ///< 3 / (4R) · (1 − (distance / R)²).
};

/// What a hit adds to the sum of its ray, with the angle θ between ray and line:
/// `value · K / sin θ · exp(−sigma·t·|d|) · exp(−line_sigma·u·length) · p`.
/// Arrays belong to the caller and are not copied.
struct GatherOptions {
  Blur blur = Blur::box;       ///< The kernel K.
  std::size_t n_channels = 1;  ///< The number of sums of each ray, 1 to 8.
  /// What each line adds: `n_channels` numbers for each line, in a row. By default, they are 1.
  std::span<const float> values = std::span<const float>();
  /// The extinction of each channel, per unit of length along the ray.
  std::array<float, 8> sigma = std::array<float, 8>();
  /// The extinction of each channel, per unit of length along the line.
  std::array<float, 8> line_sigma = std::array<float, 8>();
  /// In place of `sigma`, the optical depth of each ray at `n_depths` ≥ 2 equal steps from t_min to t_max, linear in
  /// between. Each step has one number for all channels, or one for each.
  std::span<const float> optical_depth = std::span<const float>();
  std::size_t n_depths = 0;                   ///< The number of steps of `optical_depth`.
  std::optional<float> phase = std::nullopt;  ///< g of the Henyey-Greenstein phase function p, from −1 to 1. None is 1.
  bool inner = true;     ///< Whether hits are left out whose t is an end of the ray, or that are at an end of a line.
  bool squares = false;  ///< Whether squares are summed, too.
};

/// Sums over all hits of each ray. Those of ray i are the entries from `n_channels`·i on.
struct Gathered {
  std::size_t n_channels = 1;       ///< The number of sums of each ray.
  std::vector<double> sum;          ///< The sums.
  std::vector<double> squares;      ///< The sums of squares. It is empty unless they are asked for.
  std::vector<std::int64_t> count;  ///< The number of hits of each ray that have added something.
};

}  // namespace fl
