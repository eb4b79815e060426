// The exact test of a point: how far is it from a primitive, and from which point of that? This test defines every
// answer about points, brute force included. It is compiled without contraction, so its bits are the same everywhere.
//
// Let P and Q be the ends of an axis in the frame, e = Q − P, and w = p − P. The nearest point of the axis is at
// s = w·e/e·e, clamped to [0, 1], and r = w − s·e. Where s is 1, r is p − Q instead: lines that share an end are then
// exactly as far, and the lower id wins.
//
// At the surface of a round cone, with R(s) = r₀ + s·m, s is where D − R is least (round_cone_test.hpp):
//
//     s = w·e/|e|² + h·m/(|e|·√(|e|² − m²)),    h = |w × e|/|e|,    or the end with the larger radius if |e|² ≤ m².
//
// One source serves one primitive (N = float) and 16 (N = FloatX16): the same operations in the same order.
#pragma once

#include <concepts>

#include "shapes.hpp"

namespace fastlines {

/// What the exact test reads of a point, or of 16: in the frame.
template <class Q>
concept PointView = requires(const Q& query) {
  query.p[2];                                      ///< x, y and z
  query.radius, query.radius2;                     ///< what is farther is not within; radius2 = radius²
  { query.surface } -> std::convertible_to<bool>;  ///< whether the radii of round cones count
};

/// The primitives that queries about points, pairs and regions know.
template <class P>
concept ProximityPrimitive = std::same_as<P, Segments> || std::same_as<P, RoundCones> || std::same_as<P, Shapes>;

/// The point of a primitive that is nearest to a point: s of its axis, 0 without one, and the distance in the frame,
/// less the radius at s if the surface counts.
template <class N>
struct NearestPoint {
  N s, distance;
  MaskOf<N> within;  ///< whether the distance is at most the radius of the query
};

template <class N>
[[gnu::always_inline]] inline void subtract(const N* x, const N* y, N (&to)[3]) {
  for (int k = 0; k < 3; ++k) to[k] = x[k] - y[k];
}

template <class N>
[[gnu::always_inline]] inline void cross(const N (&x)[3], const N (&y)[3], N (&to)[3]) {
  to[0] = x[1] * y[2] - x[2] * y[1];
  to[1] = x[2] * y[0] - x[0] * y[2];
  to[2] = x[0] * y[1] - x[1] * y[0];
}

/// A point and an axis from p to q.
template <class N>
struct PointAndAxis {
  N w[3], e[3], from_q[3], dot, length2;

  [[gnu::always_inline]] PointAndAxis(const N (&point)[3], const N* p, const N* q) {
    subtract(point, p, w);
    subtract(q, p, e);
    subtract(point, q, from_q);
    dot = dot3<N>(w, e);
    length2 = dot3<N>(e, e);
  }

  /// The s of the point of the axis that is nearest.
  [[gnu::always_inline]] N nearest() const {
    const N zero = 0.0f;
    return blend(zero < length2, clamp01(dot / length2), zero);
  }

  /// The s at which the distance less the radius is least; the radius at the start, and at the end less that.
  [[gnu::always_inline]] N nearest_to_surface(const N& slope) const {
    const N zero = 0.0f, one = 1.0f, rest2 = length2 - slope * slope;
    N across[3];
    cross(w, e, across);
    const N s = dot / length2 + sqrt(dot3<N>(across, across)) * slope / (length2 * sqrt(max(rest2, zero)));
    return blend(zero < rest2, clamp01(s), blend(zero < slope, one, zero));
  }

  /// The square of the distance from the point at s.
  [[gnu::always_inline]] N distance2(const N& s) const {
    const auto at_end = N(1.0f) <= s;
    N r[3];
    for (int k = 0; k < 3; ++k) r[k] = blend(at_end, from_q[k], w[k] - s * e[k]);
    return dot3<N>(r, r);
  }
};

/// The nearest point of a segment. `ends` are six coordinates in the frame.
template <class N, PointView Q>
[[gnu::always_inline]] inline NearestPoint<N> nearest_on_segment(const Q& query, const N* ends) {
  const N point[3] = {N(query.p[0]), N(query.p[1]), N(query.p[2])};
  const PointAndAxis<N> g(point, ends, ends + 3);
  const N s = g.nearest(), dist2 = g.distance2(s);
  return {s, sqrt(dist2), dist2 <= N(query.radius2)};
}

/// The radius of a round cone at s; exactly that of an end where s is 0 or 1.
template <class N>
[[gnu::always_inline]] inline N radius_at(const N& s, const N& radius0, const N& radius1) {
  return blend(N(1.0f) <= s, radius1, radius0 + s * (radius1 - radius0));
}

/// The nearest point of a round cone: its ends, and its radii there.
template <class N, PointView Q>
[[gnu::always_inline]] inline NearestPoint<N> nearest_on_round_cone(const Q& query, const N* fields) {
  if (!query.surface) return nearest_on_segment<N>(query, fields);
  const N point[3] = {N(query.p[0]), N(query.p[1]), N(query.p[2])};
  const PointAndAxis<N> g(point, fields, fields + 3);
  const N s = g.nearest_to_surface(fields[7] - fields[6]);
  const N distance = sqrt(g.distance2(s)) - radius_at(s, fields[6], fields[7]);
  return {s, distance, distance <= N(query.radius)};
}

/// The distance of a triangle, from its corners: the least of that of its edges and that of the projection onto it.
template <class N, PointView Q>
[[gnu::always_inline]] inline NearestPoint<N> nearest_on_triangle(const Q& query, const N* corners) {
  const N point[3] = {N(query.p[0]), N(query.p[1]), N(query.p[2])}, zero = 0.0f;
  N dist2 = kInfinity;
  for (int i = 0; i < 3; ++i) {
    const PointAndAxis<N> g(point, corners + 3 * i, corners + 3 * ((i + 1) % 3));
    dist2 = min(g.distance2(g.nearest()), dist2);
  }
  // The projection is A + β·u + γ·v, u being the longer one of two edges. Thin triangles have a γ with large errors, so
  // β is that of the nearest point to p on the line through A + γ·v along u. Being a point of the triangle, the
  // projection is never too near.
  N u[3], v[3], w[3], n[3], uw[3];
  subtract(corners + 3, corners, u);
  subtract(corners + 6, corners, v);
  subtract(point, corners, w);
  const auto is_shorter = dot3<N>(u, u) < dot3<N>(v, v);
  for (int k = 0; k < 3; ++k) {
    const N first = u[k];
    u[k] = blend(is_shorter, v[k], first);
    v[k] = blend(is_shorter, first, v[k]);
  }
  cross(u, v, n);
  cross(u, w, uw);
  const N length2 = dot3<N>(n, n), gamma = dot3<N>(uw, n) / length2;
  for (int k = 0; k < 3; ++k) w[k] = w[k] - gamma * v[k];
  const N beta = dot3<N>(w, u) / dot3<N>(u, u);
  for (int k = 0; k < 3; ++k) w[k] = w[k] - beta * u[k];
  const auto inside = (zero <= beta) & (zero <= gamma) & (beta + gamma <= N(1.0f)) & (zero < length2);
  dist2 = blend(inside, min(dot3<N>(w, w), dist2), dist2);
  return {zero, sqrt(dist2), dist2 <= N(query.radius2)};
}

/// The distance of a box, from its low and its high corner; 0 inside.
template <class N, PointView Q>
[[gnu::always_inline]] inline NearestPoint<N> nearest_on_box(const Q& query, const N* corners) {
  const N zero = 0.0f;
  N r[3];
  for (int k = 0; k < 3; ++k) {
    const N p = N(query.p[k]);
    r[k] = max(max(corners[k] - p, p - corners[3 + k]), zero);
  }
  const N dist2 = dot3<N>(r, r);
  return {zero, sqrt(dist2), dist2 <= N(query.radius2)};
}

/// The fields that the tests of points read: all coordinates and radii of a primitive, in the frame. `floats` is the
/// primitive as the caller gave it.
template <ProximityPrimitive P, class N, std::size_t n, class Frame>
[[gnu::always_inline]] inline std::array<N, n> point_fields(const N (&floats)[n], const Frame& frame) {
  std::array<N, n> fields;
  for (std::size_t k = 0; k < n; ++k) fields[k] = floats[k];
  const auto coordinate = [&](std::size_t k) { return (floats[k] - N(frame.centre[k % 3])) * N(frame.scale); };
  for (std::size_t k = 0; k < 6; ++k) fields[k] = coordinate(k);
  if constexpr (MixedPrimitive<P>) {
    const auto is_cone = floats[9] < N(0.5f);
    for (std::size_t k = 6; k < 9; ++k) fields[k] = blend(is_cone, floats[k] * N(frame.scale), coordinate(k));
  } else if constexpr (kHasRadius<P>) {
    for (std::size_t k = 6; k < 8; ++k) fields[k] = floats[k] * N(frame.scale);
  }
  return fields;
}

/// The fields of one primitive.
template <ProximityPrimitive P, class Frame>
[[gnu::always_inline]] inline auto point_fields_of(const typename P::Item& item, const Frame& frame) {
  float floats[sizeof(item) / sizeof(float)];
  std::memcpy(floats, &item, sizeof item);
  return point_fields<P>(floats, frame);
}

/// The nearest point of a primitive, or of 16, from its fields.
template <ProximityPrimitive P, PointView Q, class N, std::size_t n>
[[gnu::always_inline]] inline NearestPoint<N> nearest_point(const Q& query, const std::array<N, n>& fields) {
  if constexpr (MixedPrimitive<P>) {
    const N kind = fields[9], zero = 0.0f;
    const auto is_cone = kind < N(0.5f), is_box = N(1.5f) < kind;
    NearestPoint<N> found{zero, zero, zero < zero};
    const auto take = [&](const auto& mask, const NearestPoint<N>& from) __attribute__((always_inline)) {
      found.s = blend(mask, from.s, found.s);
      found.distance = blend(mask, from.distance, found.distance);
      found.within = (mask & from.within) | found.within;
    };
    const MaskOf<N> is_triangle = (N(0.5f) <= kind) & (kind <= N(1.5f));
    if (any(is_triangle)) take(is_triangle, nearest_on_triangle<N>(query, fields.data()));
    if (any(is_box)) take(is_box, nearest_on_box<N>(query, fields.data()));
    if (any(is_cone)) take(is_cone, nearest_on_round_cone<N>(query, fields.data()));
    return found;
  } else if constexpr (kHasRadius<P>) {
    return nearest_on_round_cone<N>(query, fields.data());
  } else {
    return nearest_on_segment<N>(query, fields.data());
  }
}

}  // namespace fastlines
