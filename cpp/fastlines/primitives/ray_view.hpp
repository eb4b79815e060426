// What an exact test reads of a ray.
//
// Kernels hold rays in different forms: one prepared ray, a lane or a packet of a group, 16 rays that are gathered by
// index. A view shows each of them in the same way. One test of a primitive then serves all: with N = float it gets
// one ray, and with N = FloatX16 it gets 16, or one that it tests with 16 primitives.
#pragma once

#include <concepts>

namespace fastlines {

/// A ray, or 16 of them, in the frame of the scene: the points o + t·r with t_min ≤ t ≤ t_max. A value converts to N;
/// it may be a float also where N is FloatX16, and it may be loaded each time that it is read.
template <class R, class N>
concept RayView = requires(const R& ray, int k) {
  /// The origin: the point of the ray's line that is nearest to the centre of the scene.
  { ray.o[k] } -> std::convertible_to<N>;
  /// The direction, a unit vector up to rounding. So t is a length in the frame.
  { ray.r[k] } -> std::convertible_to<N>;
  /// Two unit vectors that complete r to an orthonormal basis.
  { ray.u[k] } -> std::convertible_to<N>;
  { ray.v[k] } -> std::convertible_to<N>;
  /// The bounds on t: finite, and of any sign.
  { ray.t_min } -> std::convertible_to<N>;
  { ray.t_max } -> std::convertible_to<N>;
  /// The square of the radius of the query.
  { ray.radius2 } -> std::convertible_to<N>;
};

}  // namespace fastlines
