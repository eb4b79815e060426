// Rays with a spread κ: their reach grows by κ for each unit of length along the ray, from the caller's origin on. For
// a pixel, κ is half its width at distance 1.
//
// With z(s) the depth of the axis of a primitive at s, the reach is R(s) = r(s) + ρ + κ·z(s). In the frame the caller's
// origin lies t0·scale behind t = 0, so that z = t0·scale + p_r for a point p relative to o'.
//
// Culling uses one radius for the whole ray, ρ + G + ε, where
//
//     G = κ·max(0, t0·scale + |r_x| + |r_y| + |r_z| + δ),      δ = 2⁻¹⁹·(4 + |t0·scale| + |o'|∞).
//
// This loses nothing. All axes lie in the box of the scene, which the frame maps into [−1, 1]³. No point of it is
// deeper than t0·scale + |r_x| + |r_y| + |r_z|. So R(s) ≤ r(s) + ρ + G for every s, also for R as the exact test rounds
// it: all roundings of κ·z together are below κ·δ. A hit has D(s) ≤ R(s). So at the t of the hit the ray lies within
// r(s) + ρ + G of p(s), and within the box around p(s), if that is grown by so much: just as without a spread, with
// ρ + G for ρ. (The box need not be that of the whole round cones: z is the depth of the axis.)
//
// `check_rays` bounds ρ + κ·z in the scene as it bounds ρ. So rays that the clamps of `prepare` move are out of reach.
#pragma once

#include <type_traits>

#include "ray.hpp"

namespace fastlines {

/// Whether rays of queries on P have a spread: only with a `P::kHasSpread` that is true.
template <class P>
inline constexpr bool kHasSpread = requires { requires P::kHasSpread; };

/// How the reach of a ray grows with the depth, in the frame.
struct SpreadInFrame {
  float at_0;           ///< κ·t0·scale: by how much the reach is larger where t = 0
  float growth;         ///< G, a bound on κ·z in the scene
  float cull_growth;    ///< what is added to the culling radius: G, and its rounding
  float tie_tolerance;  ///< what is added to the tie tolerance

  /// `o` and `r` are those of the prepared ray.
  [[gnu::always_inline]] SpreadInFrame(float rate, const Vec3& o, const Vec3& r, double t0, double scale) {
    const double depth_of_0 = t0 * scale;
    const double largest = max(max(std::fabs(o[0]), std::fabs(o[1])), std::fabs(o[2]));
    const double across = double(std::fabs(r[0])) + std::fabs(r[1]) + std::fabs(r[2]);
    const double depth = depth_of_0 + across + 0x1p-19 * (4.0 + std::fabs(depth_of_0) + largest);
    at_0 = float(rate * depth_of_0);
    growth = float(rate * (depth > 0.0 ? depth : 0.0));
    cull_growth = growth * (1.0f + 0x1p-20f);
    tie_tolerance = growth * 0x1p-19f;
  }
};

/// A ray with a spread, prepared for a frame. `radius` and `eps` are those of culling, and include the spread.
struct SpreadRay : Ray {
  float spread, spread_at_0;
};

/// The prepared rays of queries on P.
template <class P>
using RayOf = std::conditional_t<kHasSpread<P>, SpreadRay, Ray>;

/// The same ray, for which hits beyond `limit`, in units of the caller's ray, need not be found.
template <class R>
R with_limit(R ray, float limit) {
  if (limit != kInfinity) ray.limit = ray.max_t(limit);
  return ray;
}

/// Prepare a ray for queries on P.
template <class P>
RayOf<P> prepare_for(const RayQuery& query, const Frame& frame) {
  if constexpr (kHasSpread<P>) {
    SpreadRay ray{prepare(query, frame), query.spread, 0.0f};
    const SpreadInFrame spread(query.spread, ray.o, ray.r, ray.t0, frame.scale);
    ray.spread_at_0 = spread.at_0;
    ray.radius += spread.growth;
    ray.eps += spread.cull_growth - spread.growth;
    ray.tie_tolerance += spread.tie_tolerance;
    return with_limit(ray, query.limit);
  } else {
    return with_limit(prepare(query, frame), query.limit);
  }
}

}  // namespace fastlines
