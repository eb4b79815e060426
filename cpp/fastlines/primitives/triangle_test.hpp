// The exact test of a triangle, in the basis of the ray: the watertight test of Woop, Benthin and Wald 2013
// ("Watertight ray/triangle intersection"). A ray that meets a closed mesh does not slip through between triangles.
//
// Let a, b, c be the corners less the ray's origin. Their coordinates along u and v are a point's projection along the
// ray, which becomes the origin. The ray's line meets the triangle if the edge functions
//
//     U = c_u·b_v − c_v·b_u,    V = a_u·c_v − a_v·c_u,    W = b_u·a_v − b_v·a_u
//
// have no two different signs, and are not all 0. It meets it at t = (U·a_r + V·b_r + W·c_r)/(U + V + W).
//
// Triangles that share an edge project its ends to the same floats, and their edge functions are negatives of each
// other. Rounding is monotonic, so the sign of an edge function is right or lost, never wrong. Where one is 0, and
// where rounding would move t by more than 2⁻²² of the frame, the lane is tested again in float64, where products of
// floats are exact. Then all signs are those of the projected corners, and t is a weighted mean of their depths.
#pragma once

#include "segment_test.hpp"

namespace fastlines {

/// Where a ray's line meets a triangle: t, and whether it does.
template <class N>
struct TriangleHit {
  N t;
  MaskOf<N> hit;
};

/// The test in float64: x is u, v and depth of the three corners.
inline TriangleHit<float> meet_triangle_in_double(const float (&x)[9]) {
  const double au = x[0], av = x[1], bu = x[3], bv = x[4], cu = x[6], cv = x[7];
  const double w[3] = {cu * bv - cv * bu, au * cv - av * cu, bu * av - bv * au};
  const bool some_below = w[0] < 0.0 || w[1] < 0.0 || w[2] < 0.0, some_above = w[0] > 0.0 || w[1] > 0.0 || w[2] > 0.0;
  const double sum = w[0] + w[1] + w[2];
  const double t = (w[0] * x[2] + w[1] * x[5] + w[2] * x[8]) / sum;
  return {float(t), some_below != some_above};
}

/// Replace the results of the lanes in `unsure` by those of float64; triangle_test_x16.hpp does it for 16.
inline void meet_triangles_in_double(const float (&x)[9], TriangleHit<float>& to, bool) {
  to = meet_triangle_in_double(x);
}

/// Test a ray and a triangle. The fields are its nine coordinates, in the frame. Only lanes in `wanted` matter.
template <class N, class R, class V>
[[gnu::always_inline]] inline TriangleHit<N> meet_triangle(const R& ray, const V& fields, MaskOf<N> wanted) {
  N x[9];  // u, v and depth of each corner
  for (int i = 0; i < 3; ++i) {
    const N p[3] = {fields[3 * i] - ray.o[0], fields[3 * i + 1] - ray.o[1], fields[3 * i + 2] - ray.o[2]};
    x[3 * i] = dot3<N>(p, ray.u);
    x[3 * i + 1] = dot3<N>(p, ray.v);
    x[3 * i + 2] = dot3<N>(p, ray.r);
  }
  const N zero = 0.0f, four = 4.0f;
  const N products[6] = {x[6] * x[4], x[7] * x[3], x[0] * x[7], x[1] * x[6], x[3] * x[1], x[4] * x[0]};
  const N u = products[0] - products[1], v = products[2] - products[3], w = products[4] - products[5];
  const N least = min(min(u, v), w), largest = max(max(u, v), w), sum = u + v + w;
  TriangleHit<N> found{(u * x[2] + v * x[5] + w * x[8]) / sum, MaskOf<N>((zero <= least) | (largest <= zero))};
  // Test again what may be wrong.
  N size = abs(products[0]);
  for (int i = 1; i < 6; ++i) size = size + abs(products[i]);
  const N depth = max(max(x[2], x[5]), x[8]) - min(min(x[2], x[5]), x[8]);
  const N smallest = min(min(abs(u), abs(v)), abs(w));
  const auto unsure = wanted & found.hit & ((smallest <= zero) | (four * abs(sum) < size * depth));
  if (any(unsure)) meet_triangles_in_double(x, found, unsure);
  return found;
}

}  // namespace fastlines
