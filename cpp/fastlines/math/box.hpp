// Axis-parallel boxes: a ≤ x ≤ b, c ≤ y ≤ d, e ≤ z ≤ f.
//
// Corners are float32, as trees store them. Areas are float64, so that rounding hardly changes a sum of many. The area
// is SA(q) = 2((b−a)(d−c) + (b−a)(f−e) + (d−c)(f−e)), and 0 for an empty box (thesis §3.1).
#pragma once

#include <algorithm>
#include <utility>

#include "vec.hpp"

namespace fastlines {

struct Box {
  Vec3 lo, hi;

  /// The box that contains no point: grown by a box, it equals that box.
  static constexpr Box empty() { return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}}; }

  bool is_empty() const { return lo[0] > hi[0] || lo[1] > hi[1] || lo[2] > hi[2]; }

  [[gnu::always_inline]] void grow(const Vec3& point) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], point[k]);
      hi[k] = std::max(hi[k], point[k]);
    }
  }

  [[gnu::always_inline]] void grow(const Box& other) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], other.lo[k]);
      hi[k] = std::max(hi[k], other.hi[k]);
    }
  }

  bool contains(const Box& other) const {
    for (int k = 0; k < 3; ++k)
      if (other.lo[k] < lo[k] || other.hi[k] > hi[k]) return false;
    return true;
  }

  /// The length of a side; negative for an empty box.
  double side(int axis) const { return double(hi[axis]) - double(lo[axis]); }

  /// The axis of the longest side; the first of equally long ones.
  int longest_axis() const {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (side(k) > side(axis)) axis = k;
    return axis;
  }

  /// The surface area of the box grown by `margin` on all sides; 0 for an empty box.
  [[gnu::always_inline]] double area(double margin = 0.0) const {
    const double x = side(0) + 2 * margin, y = side(1) + 2 * margin, z = side(2) + 2 * margin;
    return is_empty() ? 0.0 : 2.0 * (x * y + x * z + y * z);
  }

  friend bool operator==(const Box&, const Box&) = default;
};

/// What two boxes share; empty if that is nothing.
inline Box intersection(const Box& a, const Box& b) {
  Box both;
  for (int k = 0; k < 3; ++k) {
    both.lo[k] = std::max(a.lo[k], b.lo[k]);
    both.hi[k] = std::min(a.hi[k], b.hi[k]);
  }
  return both.is_empty() ? Box::empty() : both;
}

/// Both parts of a box that is cut at a plane inside it.
inline std::pair<Box, Box> halves(const Box& box, int axis, float plane) {
  Box left = box, right = box;
  left.hi[axis] = right.lo[axis] = plane;
  return {left, right};
}

/// The probability that a random line through `parent` hits `child` (thesis §1.5). Lines through a box without area
/// have measure zero; then every visit to the parent counts as a visit to the child.
inline double visit_chance(const Box& child, const Box& parent) {
  const double area = parent.area();
  return area > 0.0 ? child.area() / area : 1.0;
}

}  // namespace fastlines
