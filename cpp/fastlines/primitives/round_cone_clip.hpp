// The box of a round cone, and of its part in another box.
//
// A round cone is the union of the balls B(p(s), r(s)), s in [0, 1]. Let d(s) be the distance of p(s) from the box. The
// balls that meet the box are those with d(s) ≤ r(s). As d − r is convex, they are an interval [s0, s1]. Along an axis
// k, the ball at s reaches up to
//
//     h(s) = p_k + √(r² − the squared distance of p from the box along the other two axes),
//
// but no farther than the box. The round cone and the box are convex, so h is concave, and its maximum is found by
// golden-section search. Both searches run in float64; the result is rounded outwards.
//
// If all balls miss the box, but the nearest one by no more than the rounding of the box's float32 corners, that one
// counts as meeting it. A builder may have cut the box there.
#pragma once

#include <algorithm>
#include <cmath>

#include "round_cones.hpp"

namespace fastlines {

/// The box of a whole round cone.
inline Box bounds_of(const RoundCone& cone) {
  Box box = Box::empty();
  const auto below = [](float x, float radius) { return radius > 0.0f ? std::nextafter(x - radius, -HUGE_VALF) : x; };
  const auto above = [](float x, float radius) { return radius > 0.0f ? std::nextafter(x + radius, HUGE_VALF) : x; };
  for (int k = 0; k < 3; ++k) {
    const float p = cone.axis.p[k], q = cone.axis.q[k];
    box.lo[k] = std::min(below(p, cone.radius0), below(q, cone.radius1));
    box.hi[k] = std::max(above(p, cone.radius0), above(q, cone.radius1));
  }
  return box;
}

/// Finds the box of the part of a round cone in another box.
class RoundConeClip {
 public:
  RoundConeClip(const RoundCone& cone, const Box& box) : cone_(cone), box_(box) {
    double largest = 0.0;
    for (int k = 0; k < 3; ++k) largest = std::max({largest, std::abs(double(box.lo[k])), std::abs(double(box.hi[k]))});
    rounding_ = std::ldexp(largest, -23);
  }

  /// The box; empty if there is no part.
  Box operator()() const {
    const double nearest = minimum(0.0, 1.0, [this](double s) { return excess(s); });
    double s0 = nearest, s1 = nearest;
    if (excess(nearest) > rounding_) return Box::empty();
    if (excess(nearest) <= 0.0) {
      s0 = excess(0.0) <= 0.0 ? 0.0 : boundary(0.0, nearest);
      s1 = excess(1.0) <= 0.0 ? 1.0 : boundary(1.0, nearest);
    }
    const Box whole = bounds_of(cone_);
    Box part;
    for (int k = 0; k < 3; ++k) {
      const double low = reach(minimum(s0, s1, [&](double s) { return reach(s, k, -1.0); }), k, -1.0);
      const double high = reach(minimum(s0, s1, [&](double s) { return -reach(s, k, 1.0); }), k, 1.0);
      // The searches are accurate to far less than an ulp of float32.
      part.lo[k] = std::max({box_.lo[k], whole.lo[k], std::nextafter(float(low), -HUGE_VALF)});
      part.hi[k] = std::min({box_.hi[k], whole.hi[k], std::nextafter(float(high), HUGE_VALF)});
    }
    return part.is_empty() ? Box::empty() : part;
  }

 private:
  double axis(double s, int k) const {
    return cone_.axis.p[k] + s * (double(cone_.axis.q[k]) - double(cone_.axis.p[k]));
  }
  double radius(double s) const { return cone_.radius0 + s * (double(cone_.radius1) - double(cone_.radius0)); }

  /// The distance of a coordinate of the axis from the box.
  double outside(double s, int k) const {
    const double x = axis(s, k);
    return std::max({box_.lo[k] - x, x - box_.hi[k], 0.0});
  }

  /// How much farther from the box the axis is than its radius.
  double excess(double s) const {
    return std::sqrt(outside(s, 0) * outside(s, 0) + outside(s, 1) * outside(s, 1) + outside(s, 2) * outside(s, 2)) -
           radius(s);
  }

  /// How far the ball at s reaches along axis k, within the box: upwards (sign 1) or downwards (sign −1).
  double reach(double s, int k, double sign) const {
    const double r = radius(s), a = outside(s, (k + 1) % 3), b = outside(s, (k + 2) % 3);
    const double x = axis(s, k) + sign * std::sqrt(std::max(r * r - a * a - b * b, 0.0));
    return std::clamp(x, double(box_.lo[k]), double(box_.hi[k]));
  }

  /// The s between a and b with the least value of a convex function.
  template <class Function>
  static double minimum(double a, double b, const Function& value) {
    constexpr double golden = 0.6180339887498949;
    double c = b - golden * (b - a), d = a + golden * (b - a), at_c = value(c), at_d = value(d);
    const double first = a, last = b;
    for (int i = 0; i < 44 && b > a; ++i) {
      if (at_c < at_d) {
        b = d;
        d = c;
        at_d = at_c;
        at_c = value(c = b - golden * (b - a));
      } else {
        a = c;
        c = d;
        at_c = at_d;
        at_d = value(d = a + golden * (b - a));
      }
    }
    // Keep one of the two points: on a plateau, what lies between them and the ends may be off it.
    const double best = at_c < at_d ? c : d, least = std::min(at_c, at_d);
    if (value(first) <= least) return first;
    return value(last) <= least ? last : best;
  }

  /// The s between `out`, where the ball does not meet the box, and `in`, where it does.
  double boundary(double out, double in) const {
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (out + in);
      (excess(middle) > 0.0 ? out : in) = middle;
    }
    return in;
  }

  const RoundCone& cone_;
  const Box& box_;
  double rounding_;
};

/// The box of the part of a round cone in `box`; empty if there is none.
inline Box clipped_bounds_of(const RoundCone& cone, const Box& box) { return RoundConeClip(cone, box)(); }

}  // namespace fastlines
