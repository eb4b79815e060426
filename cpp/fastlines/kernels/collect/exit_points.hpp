// Computes where rays leave the capsules of the primitives that they hit, for the hits that are kept.
#pragma once

#include <algorithm>
#include <cstring>

#include "../intersect/load_fields.hpp"
#include "../rays/ray_views.hpp"
#include "collector.hpp"

namespace fastlines {

/// Where rays leave 16 primitives, as t in the frame: one ray leaves all of them, or each ray of a packet leaves one.
template <RayPrimitive P, class Ray>
[[gnu::always_inline]] inline FloatX16 exit_t(const WideBvhView<P>& tree, const Ray& ray, const std::uint32_t* prims) {
  const auto fields = load_fields(tree, [=](int i) { return prims[i]; });
  return P::template test<FloatX16>(ray, fields).exit();
}

/// Write where a ray leaves n primitives, in units of the caller's ray, to which `convert` converts. Writes 16 at a
/// time: `to` has room for n rounded up.
template <RayPrimitive P, class R, class Convert>
void store_exits(const WideBvhView<P>& tree, const R& ray, const Convert& convert, const std::uint32_t* prims,
                 std::uint32_t n, float* to) {
  for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
    std::uint32_t batch[kSimdWidth];
    for (std::uint32_t i = 0; i < kSimdWidth; ++i) batch[i] = prims[std::min(k + i, n - 1)];
    float t[kSimdWidth], t_ray[kSimdWidth];
    exit_t(tree, ray, batch).store(t);
    for (int i = 0; i < kSimdWidth; ++i) t_ray[i] = convert(t[i]);
    std::memcpy(to + k, t_ray, sizeof t_ray);
  }
}

/// The same for the ray in a lane.
template <RayPrimitive P>
void store_exits_of_ray(const WideBvhView<P>& tree, const RayGroup& rays, int lane, const std::uint32_t* prims,
                        std::uint32_t n, float* to) {
  store_exits(tree, LaneView(rays, lane), [&](float t) { return rays.t_ray(lane, t); }, prims, n, to);
}

/// Write where each ray of the packet at `first` leaves its primitive, in units of the caller's ray; ∞ for `kNoPrim`.
/// `prims` holds the bits of ids.
template <RayPrimitive P>
void store_exits_of_packet(const WideBvhView<P>& tree, const RayGroup& rays, const float (&prims)[kGroupSize],
                           int first, float (&to)[kGroupSize]) {
  std::uint32_t ids[kSimdWidth];
  std::memcpy(ids, prims + first, sizeof ids);
  bool hits[kSimdWidth], any_hit = false;
  for (int i = 0; i < kSimdWidth; ++i) {
    hits[i] = ids[i] != kNoPrim;
    any_hit |= hits[i];
    ids[i] = hits[i] ? ids[i] : 0;
  }
  std::fill_n(to + first, kSimdWidth, kInfinity);
  if (!any_hit) return;  // the scene may be empty, without a primitive 0
  float t[kSimdWidth];
  exit_t(tree, PacketView(rays, first), ids).store(t);
  for (int i = 0; i < kSimdWidth; ++i)
    if (hits[i]) to[first + i] = rays.t_ray(first + i, t[i]);
}

}  // namespace fastlines
