// Where rays leave the capsules of what they hit: found when it is known what that is.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>

#include "collect.hpp"
#include "sixteen.hpp"

namespace fastlines {

/// Where rays leave the capsules of sixteen segments, in the frame: one ray all of them, or sixteen one each.
template <class Ray>
[[gnu::always_inline]] inline Float16 leaving(const WideView& tree, const Ray& ray, const std::uint32_t* prims) {
  Float16 start[3], along[3];
  take_sixteen(tree, [=](int i) { return prims[i]; }, start, along);
  return leaving(ray, see<Float16>(ray, start, along));
}

/// Where the ray in this lane leaves n segments, as the caller counts t; sixteen at a time are written.
inline void leave_all(const WideView& tree, const RayLanes& rays, int lane, const std::uint32_t* prims, std::uint32_t n,
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

/// Where the sixteen rays from `first` on each leave their segment, which may be kNone, as the caller counts t. Of each
/// ray the bits of its segment's number are given.
inline void leave_each(const WideView& tree, const RayLanes& rays, const float (&prims)[kLanes], int first,
                       float (&to)[kLanes]) {
  std::uint32_t which[kWidth];
  std::memcpy(which, prims + first, sizeof which);
  bool hits[kWidth], any_hit = false;
  for (int i = 0; i < kWidth; ++i) {
    hits[i] = which[i] != kNone;
    any_hit |= hits[i];
    which[i] = hits[i] ? which[i] : 0;
  }
  std::fill_n(to + first, kWidth, std::numeric_limits<float>::infinity());
  if (!any_hit) return;  // there may be no segment
  float t[kWidth];
  leaving(tree, Rays16(rays, first), which).store(t);
  for (int i = 0; i < kWidth; ++i)
    if (hits[i]) to[first + i] = rays.t_given(first + i, t[i]);
}

}  // namespace fastlines
