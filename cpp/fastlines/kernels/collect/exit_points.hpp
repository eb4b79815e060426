// Where rays leave the capsules of what they hit: found when it is known what that is.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>

#include "../intersect/exact_test.hpp"
#include "../rays/ray_views.hpp"
#include "collector.hpp"

namespace fastlines {

/// Where rays leave 16 primitives, in the frame: one ray all of them, or a packet one each.
template <RayPrimitive P, class Ray>
[[gnu::always_inline]] inline FloatX16 exit_t(const WideBvhView<P>& tree, const Ray& ray, const std::uint32_t* prims) {
  const auto lanes = load_lanes(tree, [=](int i) { return prims[i]; });
  return P::template test<FloatX16>(ray, lanes).exit();
}

/// Where the ray in this lane leaves n segments, as the caller counts t; sixteen at a time are written.
template <RayPrimitive P>
void store_exit_ts(const WideBvhView<P>& tree, const RayGroup& rays, int lane, const std::uint32_t* prims,
                   std::uint32_t n, float* to) {
  for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
    std::uint32_t some[kSimdWidth];
    for (std::uint32_t i = 0; i < kSimdWidth; ++i) some[i] = prims[std::min(k + i, n - 1)];
    float t[kSimdWidth], t_ray[kSimdWidth];
    exit_t(tree, LaneView(rays, lane), some).store(t);
    for (int i = 0; i < kSimdWidth; ++i) t_ray[i] = rays.t_ray(lane, t[i]);
    std::memcpy(to + k, t_ray, sizeof t_ray);
  }
}

/// Where the sixteen rays from `first` on each leave their segment, which may be kNoPrim, as the caller counts t. Of
/// each ray the bits of its segment's number are t_ray.
template <RayPrimitive P>
void store_exit_t(const WideBvhView<P>& tree, const RayGroup& rays, const float (&prims)[kGroupSize], int first,
                  float (&to)[kGroupSize]) {
  std::uint32_t which[kSimdWidth];
  std::memcpy(which, prims + first, sizeof which);
  bool hits[kSimdWidth], any_hit = false;
  for (int i = 0; i < kSimdWidth; ++i) {
    hits[i] = which[i] != kNoPrim;
    any_hit |= hits[i];
    which[i] = hits[i] ? which[i] : 0;
  }
  std::fill_n(to + first, kSimdWidth, std::numeric_limits<float>::infinity());
  if (!any_hit) return;  // there may be no segment
  float t[kSimdWidth];
  exit_t(tree, PacketView(rays, first), which).store(t);
  for (int i = 0; i < kSimdWidth; ++i)
    if (hits[i]) to[first + i] = rays.t_ray(first + i, t[i]);
}

}  // namespace fastlines
