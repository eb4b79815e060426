// The exact test of a round cone, in the basis of the ray as for a segment (segment_test.hpp). With the reach
// R(s) = r(s) + ρ for a query radius ρ, and the distance D(s) of P + s·e from the ray between its bounds, the ray hits
// if D(s) ≤ R(s) for some s. D is convex and R is linear. So D − R has one minimum, and its s is the closest approach.
//
// Let a and b be P − o and e perpendicular to the ray, m = dR/ds, and h = |a × b|/|b|. If |m| ≥ |b|, the minimum is the
// end with the larger reach. Otherwise
//
//     s = −a·b/|b|² + h·m/(|b|·√(|b|² − m²)),    clamped to [0, 1].
//
// If t there is outside [t_min, t_max], the same formula holds in three dimensions, with the ray's point at the bound
// for o. With m = 0 all operations give the bits of the test of a segment.
//
// A ray with a spread κ has the reach R(s) = r(s) + ρ + κ·z(s), with z(s) the depth of the axis at s along the ray,
// from the caller's origin (rays/spread_ray.hpp). R stays linear, so all of the above holds. But it may be negative,
// for what lies behind the origin: there the ray does not hit.
//
// The ray enters the round cone at the least t of the balls B(P + s·e, R(s)): the least z(s) − √Q(s), with z the depth
// along the ray and Q(s) = R(s)² − |a + s·b|². Let s* be the closest approach, σ = s − s*, and
// Q = c₀ + 2·c₁·σ + c₂·σ². A stationary point has
//
//     k = √Q = √((c₁² − c₀·c₂)/(|e|² − m²)),    σ = (±e_r·k − c₁)/c₂,    + for the entry and − for the exit.
//
// If its s is in [0, 1], the ray meets the side of the cone there. If not, it meets the ball around an end. Since s* is
// a hit, c₀ ≥ 0, and nothing cancels.
#pragma once

#include "segment_test.hpp"

namespace fastlines {

/// A `RayView` with a spread: `spread` is κ, and `spread_at_0` is κ times the depth of t = 0 of the frame.
template <class R>
concept HasSpread = requires(const R& ray) {
  ray.spread;
  ray.spread_at_0;
};

/// The test of one ray and one round cone, or of 16 of either. It must not outlive the ray.
template <class N, class R>
class RoundConeTest {
 public:
  template <class V>
  [[gnu::always_inline]] RoundConeTest(const R& ray, const V& fields)
      : ray_(ray),
        g_(to_ray_frame<N>(ray, fields)),
        reach_(sqrt(N(ray.radius2)) + N(fields[6])),
        slope_(fields[7]),
        closest(find_closest()) {}

  /// Where a ray that comes within reach enters the round cone: t within the ray's bounds, and s of the ball there.
  [[gnu::always_inline]] ClosestApproach<N> entry() const {
    const SurfacePoint in = intersect<-1>();
    const N t = min(max(in.t, N(ray_.t_min)), N(ray_.t_max));
    const N s = blend((t < in.t) | (in.t < t), nearest_to_point(t), in.s);
    return {s, t, closest.dist2, closest.hit};
  }

  /// The t at which the ray leaves the round cone, within its bounds.
  [[gnu::always_inline]] N exit() const { return min(max(intersect<1>().t, N(ray_.t_min)), N(ray_.t_max)); }

 private:
  struct SurfacePoint {
    N t, s;
  };

  /// The s in [0, 1] at which the distance from a point or a line less the reach is least. `dot` and `cross` are a·b
  /// and |a × b|, `length2` is |b|². `end` is the answer where the reach changes at least as fast as the distance.
  [[gnu::always_inline]] N nearest(const N& dot, const N& cross, const N& length2, const N& end) const {
    const N zero = 0.0f;
    const N rest2 = length2 - slope_ * slope_;
    const N s = (zero - dot) / length2 + cross * slope_ / (length2 * sqrt(max(rest2, zero)));
    return blend(zero < rest2, clamp01(s), end);
  }

  /// The end with the larger reach; `otherwise` if both are equal.
  [[gnu::always_inline]] N larger_end(const N& otherwise) const {
    const N zero = 0.0f, one = 1.0f;
    return blend(zero < slope_, one, blend(slope_ < zero, zero, otherwise));
  }

  /// The s at which the distance from the ray's point at t less the reach is least.
  [[gnu::always_inline]] N nearest_to_point(const N& t) const {
    const N z = g_.pr - t;
    const N u = g_.pv * g_.er - z * g_.ev, v = z * g_.eu - g_.pu * g_.er, r = g_.pu * g_.ev - g_.pv * g_.eu;
    return nearest(g_.pu * g_.eu + g_.pv * g_.ev + z * g_.er, sqrt(u * u + v * v + r * r), g_.e_perp2 + g_.er * g_.er,
                   larger_end(N(0.0f)));
  }

  [[gnu::always_inline]] ClosestApproach<N> find_closest() {
    if constexpr (HasSpread<R>) {
      reach_ = reach_ + (N(ray_.spread_at_0) + N(ray_.spread) * g_.pr);
      slope_ = slope_ + N(ray_.spread) * g_.er;
    }
    // Take the closest approach of the whole line of the ray.
    const N zero = 0.0f, one = 1.0f;
    const N end = larger_end(blend(g_.er < zero, one, zero));
    const N across = abs(g_.pu * g_.ev - g_.pv * g_.eu);
    N s = blend(g_.parallel, end, nearest(g_.pu * g_.eu + g_.pv * g_.ev, across, g_.e_perp2, end));
    N t = g_.pr + s * g_.er, axial = zero;
    const MaskOf<N> early = t < ray_.t_min, outside = early | (ray_.t_max < t);
    // Move t to the bound that it exceeds.
    if (any(outside)) {
      const N bound = blend(early, ray_.t_min, ray_.t_max);
      const N at_bound = nearest_to_point(bound);
      s = blend(outside, at_bound, s);
      t = blend(outside, bound, t);
      axial = blend(outside, g_.pr - bound + at_bound * g_.er, zero);
    }
    const N x = g_.pu + s * g_.eu, y = g_.pv + s * g_.ev;
    const N dist2 = x * x + y * y + axial * axial, reach = reach_ + s * slope_;
    if constexpr (HasSpread<R>)
      return {s, t, dist2, MaskOf<N>((dist2 <= reach * reach) & (zero <= reach))};
    else
      return {s, t, dist2, dist2 <= reach * reach};
  }

  /// Where the ray's line enters (sign −1) or leaves (sign +1) the round cone. If the ray does not hit, the result is
  /// undefined and may be NaN.
  template <int sign>
  [[gnu::always_inline]] SurfacePoint intersect() const {
    const N zero = 0.0f, one = 1.0f, side = float(sign);
    // Expand Q(s) around the closest approach.
    const N x = g_.pu + closest.s * g_.eu, y = g_.pv + closest.s * g_.ev;
    const N depth = g_.pr + closest.s * g_.er, reach = reach_ + closest.s * slope_;
    const N c0 = max(reach * reach - (x * x + y * y), zero);
    const N c1 = reach * slope_ - (x * g_.eu + y * g_.ev), c2 = slope_ * slope_ - g_.e_perp2;
    // Meet the side.
    const N length2 = g_.er * g_.er - c2, discriminant = c1 * c1 - c0 * c2;
    const N k = sqrt(max(discriminant, zero) / length2), w = (zero - side) * g_.er * k;
    const N stable = (c1 * c1 - g_.er * g_.er * c0) / (length2 * (w + c1));
    const N step = blend(zero < w * c1, stable, (w - c1) / c2);
    const N s = closest.s + step;
    const N has_side = blend(g_.parallel, abs(slope_), one);  // a capsule parallel to the ray is met at an end
    const auto on_side = (zero <= s) & (s <= one) & (zero <= discriminant) & (zero < length2) & (zero < has_side);
    // Meet the ball around an end: that which the ray enters first or leaves last. Taking √Q(s) for k makes the error
    // of t on the side quadratic in that of s.
    const auto half_chord2 = [&](const N& to) { return c0 + to * (c1 + c1 + to * c2); };
    const auto t_of_ball = [&](const N& to, const N& q) { return depth + to * g_.er + side * sqrt(max(q, zero)); };
    const N step0 = zero - closest.s, step1 = one - closest.s;
    const N q0 = half_chord2(step0), q1 = half_chord2(step1);
    const N t = t_of_ball(step, half_chord2(step)), t0 = t_of_ball(step0, q0), t1 = t_of_ball(step1, q1);
    const N s_end =
        blend((q0 < zero) | (q1 < zero), blend(q0 < q1, one, zero), blend(side * t0 < side * t1, one, zero));
    const N t_end = blend(zero < s_end, t1, t0);
    return {blend(on_side, t, t_end), blend(on_side, s, s_end)};
  }

  const R& ray_;
  SegmentInRayFrame<N> g_;
  N reach_, slope_;  // R(s) = reach_ + s·slope_

 public:
  ClosestApproach<N> closest;
};

}  // namespace fastlines
