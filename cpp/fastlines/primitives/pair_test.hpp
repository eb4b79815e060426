// The exact test of a pair: how far are two axes from each other, or the surfaces of two round cones, and where? This
// test defines every answer about pairs, brute force included. It is compiled without contraction.
//
// The first axis is P + s·u, the second one T + t·v, and w = P − T. The least of five candidates counts; a later one
// only if it is less:
//
//     the ends of the first axis, with the nearest point of the second (point_test.hpp): s = 0, then s = 1;
//     the ends of the second axis, with the nearest point of the first: t = 0, then t = 1;
//     the s at which the lines are nearest, with the nearest point of the second axis to the point there.
//
// So distances are those of points (the formula of the textbooks cancels where axes are nearly parallel). With
// n = u × v, the lines are nearest at s = (v × w)·n/|n|².
//
// Between surfaces, D − r₁(s) − r₂(t) is least, with D the distance of the centres. This is convex, so the least value
// is at an edge, where the first four candidates find it, or where both derivatives vanish. With slopes m₁ and m₂ of
// the radii and x the unit vector from the second centre to the first, that is x·u = m₁ and x·v = −m₂. So
//
//     x = α·u + β·v + γ·n/|n|,    α = (m₁·v² + m₂·u·v)/|n|²,    β = −(m₂·u² + m₁·u·v)/|n|²,
//     γ² = 1 − α·m₁ + β·m₂,       D = |w·n|/(|n|·γ),            s = (v × w)·n/|n|² + α·D.
//
// There is none unless γ² > 0. Rounding of s hardly changes the distance, which is stationary there. But where tapered
// axes are nearly parallel and nearly meet, s is off by α times the rounding of D, which is that of a volume divided by
// |n|. With κ = |m₁|/|u| + |m₂|/|v| and the angle θ of the axes, this counts κ/sin²θ times in the distance.
#pragma once

#include "point_test.hpp"

namespace fastlines {

/// The nearest places of two axes or surfaces: s of the first, t of the second, and the distance in the frame, less the
/// radii there if surfaces count.
template <class N>
struct NearestPair {
  N s, t, distance;
  MaskOf<N> within;  ///< whether the distance is at most the radius of the query
};

/// The nearest place of an axis to a point with a radius of its own, and the value that ranks it: the square of the
/// distance, or the distance less the radii.
template <class N>
struct RankedPlace {
  N at, rank;
};

/// `axis` has six coordinates in the frame, and two radii if surfaces count.
template <bool surface, class N>
[[gnu::always_inline]] inline RankedPlace<N> rank_nearest(const N (&point)[3], const N& radius, const N* axis) {
  const PointAndAxis<N> g(point, axis, axis + 3);
  if constexpr (surface) {
    const N at = g.nearest_to_surface(axis[7] - axis[6]);
    return {at, sqrt(g.distance2(at)) - (radius + radius_at(at, axis[6], axis[7]))};
  } else {
    const N at = g.nearest();
    return {at, g.distance2(at)};
  }
}

/// The s at which the lines of two axes are nearest, or their surfaces are; NaN if there is none.
template <bool surface, class N>
[[gnu::always_inline]] inline N stationary_place(const N* first, const N* second) {
  N u[3], v[3], w[3], n[3], vw[3];
  subtract(first + 3, first, u);
  subtract(second + 3, second, v);
  subtract(first, second, w);
  cross(u, v, n);
  cross(v, w, vw);
  const N length2 = dot3<N>(n, n), s = dot3<N>(vw, n) / length2;
  if constexpr (!surface) {
    return s;
  } else {
    const N slope = first[7] - first[6], other_slope = second[7] - second[6], uv = dot3<N>(u, v);
    const N alpha = (slope * dot3<N>(v, v) + other_slope * uv) / length2;
    const N beta = (other_slope * dot3<N>(u, u) + slope * uv) / length2;  // −β
    const N rest2 = N(1.0f) - (alpha * slope + beta * other_slope);
    return s + alpha * (abs(dot3<N>(w, n)) / (sqrt(length2) * sqrt(rest2)));
  }
}

/// The nearest places of two primitives, or of 16 pairs. Each is six coordinates in the frame, and two radii if
/// surfaces count. `radius2` is the square of `radius`.
template <bool surface, class N>
[[gnu::always_inline]] inline NearestPair<N> nearest_pair(const N* first, const N* second, const N& radius,
                                                          const N& radius2) {
  const N zero = 0.0f, one = 1.0f;
  N s = zero, t = zero, least = kInfinity;
  const auto offer = [&](const N& at_s, const N& at_t, const N& rank) __attribute__((always_inline)) {
    const auto less = rank < least;
    s = blend(less, at_s, s);
    t = blend(less, at_t, t);
    least = blend(less, rank, least);
  };
  const auto offer_end = [&]<bool of_first>(const N* of, const N* axis, int end) __attribute__((always_inline)) {
    const N point[3] = {of[3 * end], of[3 * end + 1], of[3 * end + 2]};
    const RankedPlace<N> found = rank_nearest<surface>(point, surface ? of[6 + end] : zero, axis);
    const N at = float(end);
    offer(of_first ? at : found.at, of_first ? found.at : at, found.rank);
  };
  offer_end.template operator()<true>(first, second, 0);
  offer_end.template operator()<true>(first, second, 1);
  offer_end.template operator()<false>(second, first, 0);
  offer_end.template operator()<false>(second, first, 1);
  // Where there is no such place, s is NaN, and the start of the first axis is offered again.
  const N at = clamp01(stationary_place<surface>(first, second));
  const auto at_end = one <= at;
  N point[3];
  for (int k = 0; k < 3; ++k) point[k] = blend(at_end, first[3 + k], first[k] + at * (first[3 + k] - first[k]));
  const N own_radius = surface ? radius_at(at, first[6], first[7]) : zero;
  const RankedPlace<N> found = rank_nearest<surface>(point, own_radius, second);
  offer(at, found.at, found.rank);
  if constexpr (surface)
    return {s, t, least, least <= radius};
  else
    return {s, t, sqrt(least), least <= radius2};
}

}  // namespace fastlines
