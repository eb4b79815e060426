// The exact test: does a ray come within its radius of a segment, and where? This one function defines every answer,
// brute force included; it is compiled without contraction, so its bits are the same everywhere.
//
// With p = P − o and e = Q − P in the ray's basis (u, v, r), the distance of the ray's point at t from P + s·e is
//
//     dist²(s, t) = (p_u + s·e_u)² + (p_v + s·e_v)² + (p_r + s·e_r − t)².
//
// It is convex. For the whole line t = p_r + s·e_r, and s = −(p_u·e_u + p_v·e_v)/(e_u² + e_v²), clamped to [0, 1]. If
// that t is outside [t_min, t_max], the best t is the bound, and s is the point of the segment nearest to the ray's
// point there. Where e_u² + e_v² is rounding noise the segment is parallel to the ray, or a point: of the equally near
// points the one with the smallest t counts.
//
// One text for one ray and one segment (N = float) and for sixteen of either (N = Float16): the same operations in the
// same order, each rounded alike.
#pragma once

#include "../simd/simd.hpp"
#include "ray.hpp"

namespace fastlines {

/// Where t is taken: at the closest approach, or where the ray enters the capsule of its radius around the segment.
enum class At { closest, surface };

template <class N>
struct Approach {
  N s, t, dist2;  // t in the frame
  MaskOf<N> hit;
};

/// A segment in the basis of a ray.
template <class N>
struct Seen {
  N pu, pv, pr, eu, ev, er;
  N ee;                // |e|² across the ray
  MaskOf<N> parallel;  // ee is no more than noise
};

template <class N, class A, class B>
[[gnu::always_inline]] inline N dot3(const A& a, const B& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// `R` has o, u, v, r; start and e = end − start are in the frame.
template <class N, class R, class V>
[[gnu::always_inline]] inline Seen<N> see(const R& ray, const V& start, const V& e) {
  const N p[3] = {start[0] - ray.o[0], start[1] - ray.o[1], start[2] - ray.o[2]};
  Seen<N> seen;
  seen.pu = dot3<N>(p, ray.u);
  seen.pv = dot3<N>(p, ray.v);
  seen.pr = dot3<N>(p, ray.r);
  seen.eu = dot3<N>(e, ray.u);
  seen.ev = dot3<N>(e, ray.v);
  seen.er = dot3<N>(e, ray.r);
  seen.ee = seen.eu * seen.eu + seen.ev * seen.ev;
  const N size = max(max(abs(p[0]), abs(p[1])), abs(p[2])) + N(max(max(abs(e[0]), abs(e[1])), abs(e[2])));
  const N noise = size * N(0x1p-22f);
  seen.parallel = seen.ee <= noise * noise;
  return seen;
}

template <class R>
[[gnu::always_inline]] inline Seen<float> see(const R& ray, const Segment& segment, const Frame& frame) {
  const Vec3 start = frame(segment.p);
  return see<float>(ray, start, frame(segment.q) - start);
}

template <class N>
[[gnu::always_inline]] inline N clamp01(N s) {
  return min(max(s, N(0.0f)), N(1.0f));
}

/// `R` has t_min, t_max, radius2.
template <class N, class R>
[[gnu::always_inline]] inline Approach<N> closest_approach(const R& ray, const Seen<N>& g) {
  const N zero = 0.0f, one = 1.0f;
  N s = select(g.parallel, select(g.er < zero, one, zero), clamp01((zero - (g.pu * g.eu + g.pv * g.ev)) / g.ee));
  N t = g.pr + s * g.er, along = zero;
  const auto early = t < ray.t_min, outside = early | (ray.t_max < t);
  if (any(outside)) {
    const N bound = select(early, ray.t_min, ray.t_max);
    const N length2 = g.ee + g.er * g.er;
    const N nearest = clamp01((zero - (g.pu * g.eu + g.pv * g.ev + (g.pr - bound) * g.er)) / length2);
    const N at_bound = select(zero < length2, nearest, zero);
    s = select(outside, at_bound, s);
    t = select(outside, bound, t);
    along = select(outside, g.pr - bound + at_bound * g.er, zero);
  }
  const N x = g.pu + s * g.eu, y = g.pv + s * g.ev;
  const N dist2 = x * x + y * y + along * along;
  return {s, t, dist2, dist2 <= ray.radius2};
}

/// An end of what a line has in common with a capsule, and the s there.
template <class N>
struct CapsuleEnd {
  N t, s;
};

/// Where the line enters (sign −1) or leaves (sign +1) the capsule of its radius around the segment, if it hits; else
/// anything, or no number.
template <int sign, class N, class R>
[[gnu::always_inline]] inline CapsuleEnd<N> capsule_end(const R& ray, const Seen<N>& g) {
  const N zero = 0.0f, one = 1.0f, side = float(sign);
  const auto half_chord = [&](const N& dist2) { return sqrt(max(ray.radius2 - dist2, zero)); };
  // On the cylinder around the whole line, if the point there belongs to the segment.
  const N length2 = g.ee + g.er * g.er;
  const N s_line = (zero - (g.pu * g.eu + g.pv * g.ev)) / g.ee;
  const N x_line = g.pu + s_line * g.eu, y_line = g.pv + s_line * g.ev;
  const N t = g.pr + s_line * g.er + side * half_chord(x_line * x_line + y_line * y_line) * sqrt(length2 / g.ee);
  const N s = (zero - (g.pu * g.eu + g.pv * g.ev + (g.pr - t) * g.er)) / length2;
  // Else on the ball around an end.
  const N backwards = float(sign < 0), forwards = float(sign > 0);  // of a segment along the ray, or against it
  const N end = select(g.parallel, select(g.er < zero, backwards, forwards), select(s < zero, zero, one));
  const N x = g.pu + end * g.eu, y = g.pv + end * g.ev;
  const N t_ball = g.pr + end * g.er + side * half_chord(x * x + y * y);
  const auto on_side = (zero <= s) & (s <= one);
  return {select(g.parallel, t_ball, select(on_side, t, t_ball)), select(g.parallel, end, select(on_side, s, end))};
}

/// Where a ray that comes within its radius enters the capsule, in place of the closest approach: t between the ray's
/// bounds, and the point of the segment there.
template <class N, class R>
[[gnu::always_inline]] inline Approach<N> entry(const R& ray, const Seen<N>& g, const Approach<N>& closest) {
  const N zero = 0.0f;
  const CapsuleEnd<N> in = capsule_end<-1>(ray, g);
  const N t = min(max(in.t, N(ray.t_min)), N(ray.t_max));
  // If the ray starts inside, the nearest point of the segment there.
  const N length2 = g.ee + g.er * g.er;
  const N nearest = clamp01((zero - (g.pu * g.eu + g.pv * g.ev + (g.pr - t) * g.er)) / length2);
  const N s = select((t < in.t) | (in.t < t), select(zero < length2, nearest, zero), in.s);
  return {s, t, closest.dist2, closest.hit};
}

/// Where it leaves the capsule, between its bounds.
template <class N, class R>
[[gnu::always_inline]] inline N leaving(const R& ray, const Seen<N>& g) {
  return min(max(capsule_end<1>(ray, g).t, N(ray.t_min)), N(ray.t_max));
}

}  // namespace fastlines
