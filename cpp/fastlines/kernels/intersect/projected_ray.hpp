// The projection that leaf culling uses: onto the plane perpendicular to a ray, with axes U and V of length
// kAxisLength.
//
// Where axes must be integers (leaf_points.hpp), their components are rounded. With U' perpendicular to the ray r,
//
//     U = U' + (U·r)·r.
//
// - A leaf's origin is projected along U', its points along U. The difference for the middle of the leaf is subtracted.
//   A point is then off by |U·r| times its distance from the middle along the ray, which is at most
//   127.5·(|r_x| + |r_y| + |r_z|) quanta.
// - U' and V' turn a circle into an ellipse, whose longer semi-axis counts.
//
// Both make the culling radius larger, so that nothing is lost. With axes of length 126 it grows by half a quantum on
// average and by 2.2 at most. With axes of length 72 these are 0.9 and 3.9 quanta.
#pragma once

#include "leaf_points.hpp"

namespace fastlines {

/// The projection along a ray. N is float, or FloatX16 for a packet. `offset_from_ray` computes the offset of a leaf
/// from origin_offset and rounding_slack as one vector of four: along U, along V, the culling radius, and a factor for
/// radii.
template <class N>
struct ProjectedRayOf {
  N x[2], y[2], z[2];  // the axes U and V, or U' and V' where they are integers
  N packed[2];         // U and V as bytes, where they are integers
  N origin_offset[4];  // in the frame, times the length of the axes; [3] is 0
  // In quanta, times the length of the axes: corrections for the middle of the leaf, the slack of the radius, the
  // length.
  N rounding_slack[4];

  ProjectedRayOf() = default;
  ProjectedRayOf(const N (&o)[3], const N (&r)[3], const N (&u)[3], const N (&v)[3], N cull_radius) {
    N length = 1.0f, max_error = 0.0f;  // of the axes; of projected points
    for (int i = 0; i < 2; ++i) {
      const N(&axis)[3] = i == 0 ? u : v;
      x[i] = axis[0] * N(kAxisLength);
      y[i] = axis[1] * N(kAxisLength);
      z[i] = axis[2] * N(kAxisLength);
      packed[i] = rounding_slack[i] = 0.0f;
      if constexpr (kIntegerAxes) packed[i] = round_axis(x[i], y[i], z[i]);
    }
    if constexpr (kIntegerAxes) {
      // Make the axes perpendicular to the ray, and bound what that changes.
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
      max_error = sqrt(fma(along[0], along[0], along[1] * along[1])) * N(127.5f) * (abs(r[0]) + abs(r[1]) + abs(r[2])) +
                  N(2.0f);  // truncation
    }
    for (int i = 0; i < 2; ++i) origin_offset[i] = N(0.0f) - fma(x[i], o[0], fma(y[i], o[1], z[i] * o[2]));
    origin_offset[2] = cull_radius * length;
    rounding_slack[2] = fma(N(0.89f), length, max_error);
    origin_offset[3] = 0.0f;
    rounding_slack[3] = length;
  }
};
using ProjectedRay = ProjectedRayOf<float>;

}  // namespace fastlines
