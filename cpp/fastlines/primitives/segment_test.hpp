// The exact test of a segment: does a ray come within its radius of the segment, and where? This test defines every
// answer, brute force included. It is compiled without contraction, so its bits are the same everywhere.
//
// Let p = P − o and e = Q − P, in the ray's basis (u, v, r). The distance of the ray's point at t from P + s·e is
//
//     dist²(s, t) = (p_u + s·e_u)² + (p_v + s·e_v)² + (p_r + s·e_r − t)².
//
// This function is convex. For an unbounded ray t = p_r + s·e_r, and s = −(p_u·e_u + p_v·e_v)/(e_u² + e_v²), clamped to
// [0, 1]. If that t is outside [t_min, t_max], the best t is the bound, and s is the point of the segment nearest to
// the ray's point there. Where e_u² + e_v² is rounding noise, the segment is parallel to the ray, or a point. Of
// equally near points, the one with the smallest t counts.
//
// One source serves one ray and one segment (N = float) and 16 of either (N = FloatX16): the same operations in the
// same order, each rounded alike.
#pragma once

#include "closest_approach.hpp"

#if defined(__FAST_MATH__)
#error "answers are defined to the bit: compile without -ffast-math"
#endif

namespace fastlines {

/// A segment in the basis of a ray.
template <class N>
struct SegmentInRayFrame {
  N pu, pv, pr, eu, ev, er;
  N e_perp2;           ///< |e|² perpendicular to the ray
  MaskOf<N> parallel;  ///< e_perp2 is no more than rounding noise
};

template <class N, class A, class B>
[[gnu::always_inline]] inline N dot3(const A& a, const B& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Transform a segment into the basis of a ray. The ray is a `RayView`. The fields are those of `Segments`: the start
/// and e = end − start, in the frame.
template <class N, class R, class V>
[[gnu::always_inline]] inline SegmentInRayFrame<N> to_ray_frame(const R& ray, const V& fields) {
  const N p[3] = {fields[0] - ray.o[0], fields[1] - ray.o[1], fields[2] - ray.o[2]};
  const auto* const e = &fields[3];
  SegmentInRayFrame<N> g;
  g.pu = dot3<N>(p, ray.u);
  g.pv = dot3<N>(p, ray.v);
  g.pr = dot3<N>(p, ray.r);
  g.eu = dot3<N>(e, ray.u);
  g.ev = dot3<N>(e, ray.v);
  g.er = dot3<N>(e, ray.r);
  g.e_perp2 = g.eu * g.eu + g.ev * g.ev;
  const N size = max(max(abs(p[0]), abs(p[1])), abs(p[2])) + N(max(max(abs(e[0]), abs(e[1])), abs(e[2])));
  const N noise = size * N(0x1p-22f);
  g.parallel = g.e_perp2 <= noise * noise;
  return g;
}

template <class N>
[[gnu::always_inline]] inline N clamp01(N s) {
  return min(max(s, N(0.0f)), N(1.0f));
}

/// The closest approach of a ray to a segment.
template <class N, class R>
[[gnu::always_inline]] inline ClosestApproach<N> closest_approach(const R& ray, const SegmentInRayFrame<N>& g) {
  // Take the closest approach of the whole line of the ray.
  const N zero = 0.0f, one = 1.0f;
  N s = blend(g.parallel, blend(g.er < zero, one, zero), clamp01((zero - (g.pu * g.eu + g.pv * g.ev)) / g.e_perp2));
  N t = g.pr + s * g.er, axial = zero;
  const MaskOf<N> early = t < ray.t_min, outside = early | (ray.t_max < t);
  // Move t to the bound that it exceeds.
  if (any(outside)) {
    const N bound = blend(early, ray.t_min, ray.t_max);
    const N length2 = g.e_perp2 + g.er * g.er;
    const N nearest = clamp01((zero - (g.pu * g.eu + g.pv * g.ev + (g.pr - bound) * g.er)) / length2);
    const N at_bound = blend(zero < length2, nearest, zero);
    s = blend(outside, at_bound, s);
    t = blend(outside, bound, t);
    axial = blend(outside, g.pr - bound + at_bound * g.er, zero);
  }
  const N x = g.pu + s * g.eu, y = g.pv + s * g.ev;
  const N dist2 = x * x + y * y + axial * axial;
  return {s, t, dist2, dist2 <= ray.radius2};
}

/// A point where a line enters or leaves a capsule: t of the line, and s of the nearest point of the segment.
template <class N>
struct CapsulePoint {
  N t, s;
};

/// Where the ray's line enters (sign −1) or leaves (sign +1) the capsule of its radius around the segment. If the ray
/// does not hit, the result is undefined and may be NaN.
template <int sign, class N, class R>
[[gnu::always_inline]] inline CapsulePoint<N> intersect_capsule(const R& ray, const SegmentInRayFrame<N>& g) {
  const N zero = 0.0f, one = 1.0f, side = float(sign);
  const auto half_chord = [&](const N& dist2) { return sqrt(max(ray.radius2 - dist2, zero)); };
  // Intersect the cylinder around the whole line; valid if the point there belongs to the segment.
  const N length2 = g.e_perp2 + g.er * g.er;
  const N s_line = (zero - (g.pu * g.eu + g.pv * g.ev)) / g.e_perp2;
  const N x_line = g.pu + s_line * g.eu, y_line = g.pv + s_line * g.ev;
  const N t = g.pr + s_line * g.er + side * half_chord(x_line * x_line + y_line * y_line) * sqrt(length2 / g.e_perp2);
  const N s = (zero - (g.pu * g.eu + g.pv * g.ev + (g.pr - t) * g.er)) / length2;
  // Otherwise intersect the sphere around an end. Which end of a parallel segment it is depends on the segment's
  // direction: `forwards` if that is the ray's, `backwards` if it is the opposite.
  const N backwards = float(sign < 0), forwards = float(sign > 0);
  const N end = blend(g.parallel, blend(g.er < zero, backwards, forwards), blend(s < zero, zero, one));
  const N x = g.pu + end * g.eu, y = g.pv + end * g.ev;
  const N t_sphere = g.pr + end * g.er + side * half_chord(x * x + y * y);
  const auto on_side = (zero <= s) & (s <= one);
  return {blend(g.parallel, t_sphere, blend(on_side, t, t_sphere)), blend(g.parallel, end, blend(on_side, s, end))};
}

/// The test of one ray and one segment, or of 16 of either. Entry and exit are computed only on demand. The test must
/// not outlive the ray.
template <class N, class R>
class SegmentTest {
 public:
  template <class V>
  [[gnu::always_inline]] SegmentTest(const R& ray, const V& fields)
      : ray_(ray), g_(to_ray_frame<N>(ray, fields)), closest(closest_approach(ray, g_)) {}

  /// Where a ray that comes within its radius enters the capsule: t within the ray's bounds, and s of the segment's
  /// point there.
  [[gnu::always_inline]] ClosestApproach<N> entry() const {
    const N zero = 0.0f;
    const CapsulePoint<N> in = intersect_capsule<-1>(ray_, g_);
    const N t = min(max(in.t, N(ray_.t_min)), N(ray_.t_max));
    // If a bound moved t, take the nearest point of the segment there.
    const N length2 = g_.e_perp2 + g_.er * g_.er;
    const N nearest = clamp01((zero - (g_.pu * g_.eu + g_.pv * g_.ev + (g_.pr - t) * g_.er)) / length2);
    const N s = blend((t < in.t) | (in.t < t), blend(zero < length2, nearest, zero), in.s);
    return {s, t, closest.dist2, closest.hit};
  }

  /// Whether a ray with this entry comes in from outside: it then enters after its start.
  [[gnu::always_inline]] MaskOf<N> enters(const ClosestApproach<N>& entry) const { return N(ray_.t_min) < entry.t; }

  /// The t at which the ray leaves the capsule, within its bounds.
  [[gnu::always_inline]] N exit() const {
    return min(max(intersect_capsule<1>(ray_, g_).t, N(ray_.t_min)), N(ray_.t_max));
  }

 private:
  const R& ray_;
  SegmentInRayFrame<N> g_;

 public:
  ClosestApproach<N> closest;
};

/// A ray, or 16, whose radius is enlarged by that of a primitive: the test of its axis is then the test of a capsule.
/// It must not outlive the ray.
template <class N, class R>
struct GrownRay {
  decltype(R::o) const &o, &u, &v, &r;
  N t_min, t_max, radius2;

  [[gnu::always_inline]] GrownRay(const R& ray, const N& own_radius)
      : o(ray.o), u(ray.u), v(ray.v), r(ray.r), t_min(ray.t_min), t_max(ray.t_max) {
    const N radius = sqrt(N(ray.radius2)) + own_radius;
    radius2 = radius * radius;
  }
};

}  // namespace fastlines
