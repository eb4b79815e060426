// The distance of a point from a primitive in long double, from the definition: for tests of the float32 one.
#pragma once

#include <algorithm>
#include <cmath>

#include "fastlines/primitives/shapes.hpp"

namespace fastlines::test {

using Real = long double;

/// A point or a vector.
struct Exact {
  Real v[3];

  Exact(Real x, Real y, Real z) : v{x, y, z} {}
  explicit Exact(const Vec3& of) : v{of[0], of[1], of[2]} {}
  explicit Exact(const float* of) : v{of[0], of[1], of[2]} {}
  friend Exact operator+(const Exact& a, const Exact& b) { return {a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2]}; }
  friend Exact operator*(Real s, const Exact& a) { return {s * a.v[0], s * a.v[1], s * a.v[2]}; }
  friend Exact operator-(const Exact& a, const Exact& b) { return a + Real(-1) * b; }
  friend Real dot(const Exact& a, const Exact& b) { return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2]; }
  friend Exact cross(const Exact& a, const Exact& b) {
    return {a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2], a.v[0] * b.v[1] - a.v[1] * b.v[0]};
  }
  Real length() const { return std::sqrt(dot(*this, *this)); }
};

/// D(s) − R(s) of a round cone; its fields are both ends and both radii.
inline Real clearance(const Exact& point, const float* cone, Real s) {
  const Exact p(cone), q(cone + 3);
  return (point - (p + s * (q - p))).length() - (Real(cone[6]) + s * (Real(cone[7]) - cone[6]));
}

/// The least of D(s) − R(s), which is convex: by golden-section search.
inline Real exact_distance_of_cone(const Exact& point, const float* cone) {
  constexpr Real golden = 0.618033988749894848205L;
  Real low = 0, high = 1, a = 1 - golden, b = golden;
  Real at_a = clearance(point, cone, a), at_b = clearance(point, cone, b);
  for (int i = 0; i < 90; ++i) {
    if (at_a < at_b) {
      high = b;
      b = a;
      at_b = at_a;
      at_a = clearance(point, cone, a = high - golden * (high - low));
    } else {
      low = a;
      a = b;
      at_a = at_b;
      at_b = clearance(point, cone, b = low + golden * (high - low));
    }
  }
  return std::min({at_a, at_b, clearance(point, cone, 0), clearance(point, cone, 1)});
}

inline Real exact_distance_of_segment(const Exact& point, const float* ends) {
  const Exact p(ends), e = Exact(ends + 3) - p, w = point - p;
  const Real length2 = dot(e, e), s = length2 > 0 ? std::clamp(dot(w, e) / length2, Real(0), Real(1)) : 0;
  return (w - s * e).length();
}

inline Real exact_distance_of_triangle(const Exact& point, const float* corners) {
  Real least = kInfinity;
  for (int i = 0; i < 3; ++i) {
    float edge[6];
    std::copy_n(corners + 3 * i, 3, edge);
    std::copy_n(corners + 3 * ((i + 1) % 3), 3, edge + 3);
    least = std::min(least, exact_distance_of_segment(point, edge));
  }
  const Exact a(corners), u = Exact(corners + 3) - a, v = Exact(corners + 6) - a, n = cross(u, v), w = point - a;
  const Real length2 = dot(n, n);
  if (!(length2 > 0)) return least;
  const Real beta = dot(cross(w, v), n) / length2, gamma = dot(cross(u, w), n) / length2;
  const bool is_inside = beta >= 0 && gamma >= 0 && beta + gamma <= 1;
  return is_inside ? std::min(least, std::abs(dot(w, n)) / n.length()) : least;
}

inline Real exact_distance_of_box(const Exact& point, const float* corners) {
  Real sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Real beyond = std::max({Real(corners[k]) - point.v[k], point.v[k] - Real(corners[3 + k]), Real(0)});
    sum += beyond * beyond;
  }
  return std::sqrt(sum);
}

/// The distance of a shape, or of its axis.
inline Real exact_distance(const Exact& point, const Shape& shape, bool surface) {
  switch (shape.kind()) {
    case Shape::round_cone:
      return surface ? exact_distance_of_cone(point, shape.numbers) : exact_distance_of_segment(point, shape.numbers);
    case Shape::triangle:
      return exact_distance_of_triangle(point, shape.numbers);
    default:
      return exact_distance_of_box(point, shape.numbers);
  }
}

}  // namespace fastlines::test
