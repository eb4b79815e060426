// Smooth directions of polylines: those of splines through the same points. fastlines.geometry.smooth_tangents has the
// definition.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "../math/vec.hpp"

namespace fastlines {

/// Segments and the strand of each.
struct StrandSegments {
  std::span<const std::array<Vec3, 2>> segments;
  std::span<const std::int64_t> strands;

  /// Strands have a corner where the cosine of a turn is smaller.
  static constexpr float kCorner = 0.5f;

  /// The direction at the place u of a segment, which has the direction `tangent`.
  Vec3 smooth_tangent(std::size_t i, float u, const Vec3& tangent) const {
    const bool is_led = i > 0 && is_joined(i - 1), is_led_on = i + 1 < segments.size() && is_joined(i);
    const Vec3 first = unit(is_led ? tangent + turned(i - 1, tangent) : tangent);
    const Vec3 second = unit(is_led_on ? tangent + turned(i + 1, tangent) : tangent);
    return unit(first * (1.0f - u) + second * u);
  }

 private:
  static Vec3 unit(const Vec3& v) {
    double length2 = 0.0;  // the square of a float may not be one
    for (const float x : v) length2 += double(x) * double(x);
    const auto length = float(std::sqrt(length2));
    return length > 0.0f ? v * (1.0f / length) : Vec3{};
  }
  bool is_joined(std::size_t i) const { return strands[i] == strands[i + 1] && segments[i][1] == segments[i + 1][0]; }
  /// The direction of a neighbour; zero at a corner.
  Vec3 turned(std::size_t i, const Vec3& tangent) const {
    const Vec3 direction = unit(segments[i][1] - segments[i][0]);
    return dot(direction, tangent) > kCorner ? direction : Vec3{};
  }
};

}  // namespace fastlines
