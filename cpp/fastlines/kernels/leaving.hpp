// Where rays leave the capsules of what they hit: found when it is known what that is.
#pragma once

#include "lanes.hpp"
#include "sixteen.hpp"

namespace fastlines {

/// Where rays leave the capsules of sixteen segments, in the frame: one ray all of them, or sixteen one each.
template <class Ray>
[[gnu::always_inline]] inline Float16 leaving(const WideView& tree, const Ray& ray, const std::uint32_t* prims) {
  Float16 start[3], along[3];
  take_sixteen(tree, [=](int i) { return prims[i]; }, start, along);
  return leaving(ray, see<Float16>(ray, start, along));
}

/// The same of the ray in this lane and n segments, as the caller counts; sixteen at a time are written.
inline void leave(const WideView& tree, const RayLanes& rays, int lane, const std::uint32_t* prims, std::uint32_t n,
                  float* to) {
  for (std::uint32_t k = 0; k < n; k += kWidth) {
    std::uint32_t some[kWidth];
    for (std::uint32_t i = 0; i < kWidth; ++i) some[i] = prims[std::min(k + i, n - 1)];
    float t[kWidth], given[kWidth];
    leaving(tree, RayInLane(rays, lane), some).store(t);
    for (int i = 0; i < kWidth; ++i) given[i] = rays.t_given(lane, t[i]);
    std::memcpy(to + k, given, sizeof given);
  }
}

}  // namespace fastlines
