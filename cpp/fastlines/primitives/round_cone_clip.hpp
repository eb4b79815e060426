// The box of a round cone, and of its part in another box.
//
// A round cone is the union of the balls B(p(s), r(s)), s in [0, 1], with p and r linear in s. Let g_k(s) be how far
// p(s) is outside the box along axis k. The balls that meet the box are those with room(s) = r² − Σ g² ≥ 0. As √(Σ g²)
// − r is convex, they are an interval [s0, s1]. Along an axis k, the ball at s reaches up to
//
//     h(s) = p_k + √(r² − Σ g² over the other two axes),
//
// but no farther than the box. The round cone and the box are convex, so h is concave. Between the places where p
// crosses a side of the box, each g is linear. There, room and the radicand Q of h are quadratic polynomials, and h is
// largest at an end or where its derivative is 0: Q'² = 4·p_k'²·Q. fastlines.theory.cone clips in the same way.
//
// All is computed in float64. Where the boundary only grazes a ball, roots are double and known to half of the digits
// only, so s0 and s1 are moved apart by 2⁻²⁴, and the result is rounded outwards by 2⁻²⁵ of the round cone's size.
//
// If all balls miss the box, but the nearest one by no more than the rounding of the box's float32 corners, that one
// counts as meeting it. A builder may have cut the box there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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
    for (int k = 0; k < 3; ++k) {
      start_[k] = cone.axis.p[k];
      step_[k] = double(cone.axis.q[k]) - double(cone.axis.p[k]);
    }
    start_[3] = cone.radius0;
    step_[3] = double(cone.radius1) - double(cone.radius0);
    margin_ = 0x1p-25 * std::max({std::abs(step_[0]), std::abs(step_[1]), std::abs(step_[2]), at(3, 0.0), at(3, 1.0)});
    find_spans();
    find_balls();
  }

  /// The box; empty if there is no part.
  Box operator()() const {
    if (first_ > last_) return Box::empty();
    const Box whole = bounds_of(cone_);
    Box part;
    for (int k = 0; k < 3; ++k) {
      const double lo = box_.lo[k], hi = box_.hi[k];
      const double low = std::clamp(-farthest(k, -1.0), lo, hi), high = std::clamp(farthest(k, 1.0), lo, hi);
      part.lo[k] = std::max({box_.lo[k], whole.lo[k], std::nextafter(float(low - margin_), -HUGE_VALF)});
      part.hi[k] = std::min({box_.hi[k], whole.hi[k], std::nextafter(float(high + margin_), HUGE_VALF)});
    }
    return part.is_empty() ? Box::empty() : part;
  }

 private:
  /// x + y·s.
  struct Linear {
    double x, y;
    double operator()(double s) const { return x + s * y; }
  };
  /// a·s² + b·s + c.
  struct Quadratic {
    double a, b, c;

    double discriminant() const { return b * b - 4.0 * a * c; }
    /// The roots, or no finite numbers where there are none.
    std::array<double, 2> roots(double root_of_discriminant) const {
      const double larger = -0.5 * (b + std::copysign(root_of_discriminant, b));  // without cancellation
      return {larger / a, c / larger};
    }
  };
  /// An interval of s, and g on each axis there.
  struct Span {
    double first, last;
    std::array<Linear, 3> gaps;
  };

  double at(int k, double s) const { return start_[k] + s * step_[k]; }
  double radius(double s) const { return at(3, s); }

  void find_spans() {
    std::array<double, 8> ends{0.0};
    int n = 1;
    for (int k = 0; k < 3; ++k) {
      for (const float side : {box_.lo[k], box_.hi[k]}) {
        const double s = (side - start_[k]) / step_[k];  // not between 0 and 1 if the step is 0
        if (!(s > 0.0 && s < 1.0)) continue;
        int at = n++;
        for (; ends[at - 1] > s; --at) ends[at] = ends[at - 1];
        ends[at] = s;
      }
    }
    ends[n] = 1.0;
    for (; n_spans_ < n; ++n_spans_) {
      Span& span = spans_[n_spans_];
      span.first = ends[n_spans_];
      span.last = ends[n_spans_ + 1];
      for (int k = 0; k < 3; ++k) {
        const double middle = at(k, 0.5 * (span.first + span.last));
        const double side = std::clamp(middle, double(box_.lo[k]), double(box_.hi[k]));
        span.gaps[k] = side == middle ? Linear{0.0, 0.0} : Linear{start_[k] - side, step_[k]};
      }
    }
  }

  /// Finds [first_, last_], the balls that meet the box.
  void find_balls() {
    double largest = 0.0, nearest = 0.0, least = HUGE_VAL;
    for (int k = 0; k < 3; ++k)
      largest = std::max({largest, std::abs(double(box_.lo[k])), std::abs(double(box_.hi[k]))});
    const auto add = [this](double s) {
      first_ = std::min(first_, s);
      last_ = std::max(last_, s);
    };
    for (int i = 0; i < n_spans_; ++i) {
      const Span& span = spans_[i];
      const Quadratic room = room_of(span);
      for (const double s : room.roots(std::sqrt(room.discriminant()))) {
        if (s >= span.first && s <= span.last) add(s);
      }
      for (const double s : {span.first, std::clamp(-0.5 * room.b / room.a, span.first, span.last), span.last}) {
        if (std::isnan(s)) continue;
        const double excess = excess_at(span, s);
        if (excess <= 0.0) add(s);
        if (excess < least) {
          least = excess;
          nearest = s;
        }
      }
    }
    if (first_ > last_ && least <= std::ldexp(largest, -22)) add(nearest);
    if (first_ > last_) return;
    first_ = std::max(first_ - 0x1p-24, 0.0);
    last_ = std::min(last_ + 0x1p-24, 1.0);
  }

  /// r² − Σ g², without one axis if it is given.
  Quadratic room_of(const Span& span, int without = -1) const {
    Quadratic room{step_[3] * step_[3], start_[3] * step_[3], start_[3] * start_[3]};
    for (int k = 0; k < 3; ++k) {
      if (k == without) continue;
      const auto [x, y] = span.gaps[k];
      room.a -= y * y;
      room.b -= x * y;
      room.c -= x * x;
    }
    room.b *= 2.0;
    return room;
  }

  /// How much farther from the box the axis is than its radius.
  double excess_at(const Span& span, double s) const {
    const auto& g = span.gaps;
    return std::sqrt(g[0](s) * g[0](s) + g[1](s) * g[1](s) + g[2](s) * g[2](s)) - radius(s);
  }

  /// How far balls reach in the box along axis k: upwards (sign 1), or downwards (sign −1), counted in that direction.
  double farthest(int k, double sign) const {
    double found = -HUGE_VAL;
    for (int i = 0; i < n_spans_; ++i) {
      const Span& span = spans_[i];
      const double first = std::max(span.first, first_), last = std::min(span.last, last_);
      if (first > last) continue;
      const auto reach_to = [&](double s) {
        if (!(s >= first && s <= last)) return;
        const double r = radius(s), a = span.gaps[(k + 1) % 3](s), b = span.gaps[(k + 2) % 3](s);
        found = std::max(found, sign * at(k, s) + std::sqrt(std::max(r * r - a * a - b * b, 0.0)));
      };
      reach_to(first);
      reach_to(last);
      const Quadratic q = room_of(span, k);
      const double square = step_[k] * step_[k], rise = q.a - square;
      const Quadratic slope{4.0 * q.a * rise, 4.0 * q.b * rise, q.b * q.b - 4.0 * square * q.c};
      const double root = 4.0 * std::abs(step_[k]) * std::sqrt(-rise * q.discriminant());
      for (const double s : slope.roots(root)) reach_to(s);
    }
    return found;
  }

  const RoundCone& cone_;
  const Box& box_;
  std::array<double, 4> start_, step_;  // of the axis and the radius
  std::array<Span, 7> spans_;
  int n_spans_ = 0;
  double margin_, first_ = HUGE_VAL, last_ = -HUGE_VAL;
};

/// The box of the part of a round cone in `box`; empty if there is none.
inline Box clipped_bounds_of(const RoundCone& cone, const Box& box) { return RoundConeClip(cone, box)(); }

}  // namespace fastlines
