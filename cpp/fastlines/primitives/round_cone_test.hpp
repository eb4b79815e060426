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
// along the ray and Q(s) = R(s)² − |a + s·b|². Around any s₀, with σ = s − s₀ and c₂ = m² − |b|², let
// Q = c₀ + 2·c₁·σ + c₂·σ². A stationary point has
//
//     k = √Q = √(D/(|e|² − m²)),    D = c₁² − c₀·c₂,    σ = (w − c₁)/c₂,    w = ±e_r·k,
//
// with + for the entry and − for the exit. There the ray touches a ball on the side of the cone. z − √Q is convex, so s
// is clamped to [0, 1]. If c₂ ≥ 0, the ray meets the side only if |m| < |e| and w has the sign of m; otherwise it meets
// the larger end.
//
// At a tip, where R is 0, rounding must not grow with the radius of the other end:
//
// - Q is expanded around the smaller end if |b|² < 2·m². Then no |a + σ·b| is much larger than the reach at s, and Q is
//   off by a few roundings of R(s)². Otherwise Q is expanded around the closest approach, where R is of the same size.
// - If c₂ < 0, D is computed at the closest approach: since that is a hit, c₀ ≥ 0, and nothing cancels. Otherwise
//   D = |m·a − R·b|² − (a × b)², which is 0 only for a ray through the apex. Both are the same around each s₀.
// - If w and c₁ have the same sign, σ = (c₁² − e_r²·c₀)/((|e|² − m²)·(w + c₁)).
// - If the ray grazes the side along its whole length, c₁ and c₂ are rounding noise. If the ray then misses the ball
//   by more than it dips into that of the closest approach, the latter is taken. With R and c₀ at the closest approach,
//   it dips by about c₀/(2·R).
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
    const MaskOf<N> moved = (t < in.t) | (in.t < t);
    N s = in.s;
    if (any(moved)) s = blend(moved, nearest_to_point(t), s);
    return {s, t, closest.dist2, closest.hit};
  }

  /// Whether a ray with this entry comes in from outside: it then enters after its start.
  [[gnu::always_inline]] MaskOf<N> enters(const ClosestApproach<N>& entry) const { return N(ray_.t_min) < entry.t; }

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

  /// The ball at s: its centre across the ray, its reach, Q, and half the derivative of Q.
  struct Ball {
    N x, y, reach, c0, c1;
  };

  [[gnu::always_inline]] Ball ball_at(const N& s) const {
    const N x = g_.pu + s * g_.eu, y = g_.pv + s * g_.ev, reach = reach_ + s * slope_;
    return {x, y, reach, reach * reach - (x * x + y * y), reach * slope_ - (x * g_.eu + y * g_.ev)};
  }

  /// Where the ray's line enters (sign −1) or leaves (sign +1) the round cone. If the ray does not hit, the result is
  /// undefined and may be NaN.
  template <int sign>
  [[gnu::always_inline]] SurfacePoint intersect() const {
    const N zero = 0.0f, one = 1.0f, side = float(sign), ahead = (zero - side) * g_.er;
    const N m2 = slope_ * slope_, c2 = m2 - g_.e_perp2, length2 = g_.er * g_.er - c2;
    const MaskOf<N> tapers = g_.e_perp2 < m2 + m2, is_steep = zero <= c2;
    // Expand Q.
    const Ball deepest = ball_at(closest.s);
    Ball ball = deepest;
    N from = closest.s, discriminant = ball.c1 * ball.c1 - ball.c0 * c2;
    if (any(tapers)) {
      from = blend(tapers, blend(zero < slope_, zero, one), from);
      ball = ball_at(from);
      const N x = slope_ * ball.x - ball.reach * g_.eu, y = slope_ * ball.y - ball.reach * g_.ev;
      const N across = ball.x * g_.ev - ball.y * g_.eu;
      discriminant = blend(is_steep, x * x + y * y - across * across, discriminant);
    }
    // Find the ball that the ray touches.
    const N w = ahead * sqrt(max(discriminant, zero) / length2);
    const MaskOf<N> cancels = zero < w * ball.c1;
    const N step = blend(cancels, ball.c1 * ball.c1 - g_.er * g_.er * ball.c0, w - ball.c1) /
                   blend(cancels, length2 * (w + ball.c1), c2);
    // Clamp s to the axis. A ray parallel to a capsule touches the ball at an end.
    const N touched = from + step;
    const MaskOf<N> at_end = (is_steep & ((ahead * slope_ <= zero) | (length2 <= zero))) | (g_.parallel & (m2 <= zero));
    N s = blend(at_end, larger_end(blend(ahead < zero, one, zero)), clamp01(touched));
    const N to = blend((s <= touched) & (touched <= s), step, s - from);
    N depth = g_.pr + from * g_.er + to * g_.er, q = ball.c0 + to * (ball.c1 + ball.c1 + to * c2);
    // Take the ball at the closest approach if the ray misses this one by more.
    if (any(tapers)) {
      const N reach = ball.reach + to * slope_;
      const MaskOf<N> misses = tapers & (deepest.c0 * (reach * deepest.reach + N(0.25f) * deepest.c0) <
                                         (zero - q) * (deepest.reach * deepest.reach));
      s = blend(misses, closest.s, s);
      depth = blend(misses, g_.pr + closest.s * g_.er, depth);
      q = blend(misses, deepest.c0, q);
    }
    return {depth + side * sqrt(max(q, zero)), s};
  }

  const R& ray_;
  SegmentInRayFrame<N> g_;
  N reach_, slope_;  // R(s) = reach_ + s·slope_

 public:
  ClosestApproach<N> closest;
};

}  // namespace fastlines
