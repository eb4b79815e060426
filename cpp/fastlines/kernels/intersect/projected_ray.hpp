// A ray as leaves see it: along itself, in a plane across it, in quanta of a leaf. Where a leaf lies there is found
// from this and the leaf's origin.
//
// Where the plane's axes have to be whole numbers (simd/points.hpp), they are those nearest to kAxisLength times the
// true ones, U = U' + (U·r)·r with U' across the ray. A leaf's origin is seen along U', its points along U, less what
// the middle of the leaf is off by. So a point is off by |U·r| times how far along the ray it lies from the middle, at
// most 127.5·(|r_x| + |r_y| + |r_z|). And U' and V' make a circle an ellipse, of which the longer axis counts. All this
// makes reach larger, nothing is lost: with axes of 126, by half a quantum in the mean and by 2.2 at most, with those
// of 72 by 0.9 and 3.9.
#pragma once

#include "leaf_points.hpp"

namespace fastlines {

/// A ray as leaves see it, or sixteen: N is float or FloatX16. What is found of a leaf at once stands side by side.
template <class N>
struct ProjectedRayOf {
  N x[2], y[2], z[2];  // the axes across
  N packed[2];         // and as bytes
  N origin_offset[4],
      rounding_slack[4];  // where the leaf's origin lies along both, and how near counts; the last is nothing

  ProjectedRayOf() = default;
  ProjectedRayOf(const N (&o)[3], const N (&r)[3], const N (&u)[3], const N (&v)[3], N reach) {
    N length = 1.0f, astray = 0.0f;  // of the axes; how far points may be off
    for (int i = 0; i < 2; ++i) {
      const N(&axis)[3] = i == 0 ? u : v;
      x[i] = axis[0] * N(kAxisLength);
      y[i] = axis[1] * N(kAxisLength);
      z[i] = axis[2] * N(kAxisLength);
      packed[i] = rounding_slack[i] = 0.0f;
      if constexpr (kIntegerAxes) packed[i] = round_axis(x[i], y[i], z[i]);
    }
    if constexpr (kIntegerAxes) {
      N along[2];
      for (int i = 0; i < 2; ++i) {
        along[i] = fma(x[i], r[0], fma(y[i], r[1], z[i] * r[2]));
        x[i] = x[i] - along[i] * r[0];
        y[i] = y[i] - along[i] * r[1];
        z[i] = z[i] - along[i] * r[2];
        rounding_slack[i] = along[i] * (N(-127.5f) * (r[0] + r[1] + r[2]));
      }
      const auto dot = [&](int i, int j) { return fma(x[i], x[j], fma(y[i], y[j], z[i] * z[j])); };
      length = sqrt(max(dot(0, 0), dot(1, 1)) + abs(dot(0, 1))) * N(1.0f + 1e-6f);
      astray = sqrt(fma(along[0], along[0], along[1] * along[1])) * N(127.5f) * (abs(r[0]) + abs(r[1]) + abs(r[2])) +
               N(2.0f);  // truncation
    }
    for (int i = 0; i < 2; ++i) origin_offset[i] = N(0.0f) - fma(x[i], o[0], fma(y[i], o[1], z[i] * o[2]));
    origin_offset[2] = reach * length;
    rounding_slack[2] = fma(N(0.89f), length, astray);
    origin_offset[3] = 0.0f;
    rounding_slack[3] = length;
  }
};
using ProjectedRay = ProjectedRayOf<float>;

}  // namespace fastlines
