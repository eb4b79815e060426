// Cubic Bezier curves in float64: their directions and radii, eight at a time, and the pieces that places on them are
// on. geometry/bezier.py and geometry/curve_pieces.py define these.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "../simd/double_x8.hpp"

namespace fastlines {

/// Curves, and the pieces that each is cut into: those of curve i are first[i] up to first[i + 1].
struct CubicCurves {
  using Control = std::array<std::array<float, 3>, 4>;
  using Radii = std::array<float, 4>;

  std::span<const Control> control;
  std::span<const Radii> radii;  ///< empty without a radius
  std::span<const std::int64_t> first;
  std::span<const float> begin, end;  ///< the parameter of the curve at both ends of each piece

  /// Pieces begin at multiples of it.
  static constexpr double kUnits = 1 << 20;

  /// The last piece of the curve that begins at or before u. The last unit of a curve includes its end.
  std::size_t piece_of(std::int64_t curve, double u) const {
    const double unit = std::min(std::floor(u * kUnits), kUnits - 1);
    const float *const from = begin.data() + first[curve] + 1, *const to = begin.data() + first[curve + 1];
    return std::size_t(std::upper_bound(from, to, float(unit / kUnits)) - begin.data() - 1);
  }
};

/// The parameter of a curve at s on a piece of it.
inline float parameter_on(float begin, float end, float s) {
  const auto u = float(begin + double(s) * (double(end) - begin));
  return std::min(std::max(u, begin), end);
}

/// Interpolates linearly.
template <class T>
T mix(const DoubleX8& t, const T& a, const T& b) {
  return (DoubleX8(1.0) - t) * a + t * b;
}

/// The values of eight cubics at t.
inline DoubleX8 cubic_at(const DoubleX8 (&b)[4], const DoubleX8& t) {
  const DoubleX8 q[3] = {mix(t, b[0], b[1]), mix(t, b[1], b[2]), mix(t, b[2], b[3])};
  return mix(t, mix(t, q[0], q[1]), mix(t, q[1], q[2]));
}

/// The unit vectors along eight curves at t. Where a curve stands still, it is where it goes on, or came from at its
/// end; NaN if it never moves.
inline Vector3<DoubleX8> direction_at(const std::array<Vector3<DoubleX8>, 4>& b, const DoubleX8& t) {
  constexpr double no_derivative = 0x1p-40;  // smaller fractions of the control polygon's longest side count as zero
  const auto length = [](const Vector3<DoubleX8>& v) { return sqrt(dot(v, v)); };
  const Vector3<DoubleX8> edge[3] = {b[1] - b[0], b[2] - b[1], b[3] - b[2]};
  DoubleX8 longest = 0.0;
  for (const Vector3<DoubleX8>& each : edge) longest = blend(longest < length(each), length(each), longest);
  const Vector3<DoubleX8> q[3] = {mix(t, b[0], b[1]), mix(t, b[1], b[2]), mix(t, b[2], b[3])};
  const Vector3<DoubleX8> second = (q[2] - q[1]) - (q[1] - q[0]);
  // Take the first derivative that is not zero; the second points backwards at the end.
  Vector3<DoubleX8> direction = (edge[2] - edge[1]) - (edge[1] - edge[0]);
  const auto take = [&](const Vector3<DoubleX8>& v) {
    direction = blend(DoubleX8(no_derivative) * longest < length(v), v, direction);
  };
  take(blend(t < DoubleX8(1.0), second, -second));
  take(mix(t, q[1], q[2]) - mix(t, q[0], q[1]));
  return direction / length(direction);
}

}  // namespace fastlines
