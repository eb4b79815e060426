// The first hit of each ray.
#pragma once

#include <bit>

#include "../../rays/hit.hpp"
#include "collector.hpp"
#include "exit_points.hpp"

namespace fastlines {

/// The first hits.
template <At at_>
struct FirstHitCollector {
  static constexpr QueryTraits kTraits{.shrinks_limit = true, .drops_farther = true};
  static constexpr At kAt = at_;
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  alignas(64) float t[kGroupSize], s[kGroupSize], dist2[kGroupSize], prim[kGroupSize];  // prim: the bits of an integer

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(t + first, t + round_up_to_width(end), std::numeric_limits<float>::infinity());
    for (float* zero : {s, dist2})
      std::fill(zero + first, zero + round_up_to_width(end), 0.0f);  // read before it is known
    std::fill(prim + first, prim + round_up_to_width(end), std::bit_cast<float>(kNoPrim));
  }

  void add_packet(const RayGroup& rays, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                  std::uint32_t prim_) {
    const auto at = [first](float* x) { return FloatX16::load(x + first); };
    const FloatX16 tie_tolerance = FloatX16::load(rays.tie_tolerance + first), best = at(t);
    const MaskX16 surely = approach.hit & (approach.t + tie_tolerance < best);
    std::uint32_t unsure = hit & ~surely.bits() & may_precede(approach.t, best, tie_tolerance).bits();
    const auto set = [&](float* x, FloatX16 to) { blend(surely, to, at(x)).store(x + first); };
    set(t, approach.t);
    set(s, approach.s);
    set(dist2, approach.dist2);
    set(prim, FloatX16(std::bit_cast<float>(prim_)));
    limit_changed |= any(surely);
    for (; unsure; unsure &= unsure - 1) resolve_tie(rays, first, std::countr_zero(unsure), approach, prim_);
  }

  /// Bring the limits of rays [first, end) nearer, to what `take` has found: once for many of its calls.
  void tighten_limits(const RayGroup& rays, int first, int end) {
    for (int i = first; i < end; i += kSimdWidth)
      min(FloatX16::load(t + i) + FloatX16::load(rays.tie_tolerance + i), FloatX16::load(limit + i)).store(limit + i);
  }

  /// The t of both are so near that they may be the same to the caller; then the lower id counts.
  void resolve_tie(const RayGroup& rays, int first, int lane, const ClosestApproach<FloatX16>& approach,
                   std::uint32_t prim_) {
    alignas(64) float ts[kSimdWidth], ss[kSimdWidth], dist2s[kSimdWidth];
    approach.t.store(ts);
    const int i = first + lane;
    if (!comes_first(rays, i, ts[lane], prim_)) return;
    approach.s.store(ss);
    approach.dist2.store(dist2s);
    set(rays, i, {ts[lane], ss[lane], dist2s[lane]}, prim_);
  }

  void add_hit(const RayGroup& rays, int i, const ClosestApproach<float>& approach, const Reference& ref) {
    const float tie_tolerance = rays.tie_tolerance[i];
    if (!may_precede(approach.t, t[i], tie_tolerance)) return;
    if (approach.t + tie_tolerance < t[i] || comes_first(rays, i, approach.t, ref.prim))
      set(rays, i, {approach.t, approach.s, approach.dist2}, ref.prim);
  }

 private:
  struct Place {
    float t, s, dist2;
  };

  /// Whether the caller counts this hit as the first.
  bool comes_first(const RayGroup& rays, int i, float t_, std::uint32_t prim_) const {
    const float t_ray = rays.t_ray(i, t_), best = rays.t_ray(i, t[i]);
    return precedes(t_ray, prim_, best, std::bit_cast<std::uint32_t>(prim[i]));
  }

  void set(const RayGroup& rays, int i, const Place& place, std::uint32_t prim_) {
    t[i] = place.t;
    s[i] = place.s;
    dist2[i] = place.dist2;
    prim[i] = std::bit_cast<float>(prim_);
    limit[i] = min(place.t + rays.tie_tolerance[i], rays.t_max[i]);
    limit_changed = true;
  }
};

/// The first hit of each ray.
template <RayPrimitive P, At at>
struct FirstHitQuery {
  using Collector = FirstHitCollector<at>;
  const WideBvhView<P>& tree;
  HitColumns to;

  Collector collector() const { return {}; }

  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    constexpr Hit miss;
    float t[kGroupSize], u[kGroupSize], distance[kGroupSize], t_out[kGroupSize];
    std::int64_t prim[kGroupSize];
    const double inv_scale = rays.inv_scale;
    for (int from = first; from < end; from += kSimdWidth)
      for (int i = from; i < from + kSimdWidth;
           ++i) {  // of no certain number, or with branches, it would not be vectors
        const auto which = std::bit_cast<std::uint32_t>(found.prim[i]);
        const bool hit = which != kNoPrim;
        const float t_ = rays.t_ray(i, found.t[i]), distance_ = float(std::sqrt(found.dist2[i]) * inv_scale);
        t[i] = hit ? t_ : miss.t;
        u[i] = hit ? found.s[i] : miss.u;
        distance[i] = hit ? distance_ : miss.distance;
        prim[i] = hit ? std::int64_t(which) : miss.prim;
      }
    if constexpr (at == At::surface)
      for (int from = first; from < end; from += kSimdWidth) store_exit_t(tree, rays, found.prim, from, t_out);
    const HitColumns columns = to;  // a copy, so that nothing written can alias it
    const auto write = [&](int i, auto n) __attribute__((always_inline)) {
      const std::uint32_t at_ = rays.id[i];
      std::copy_n(t + i, n, columns.t + at_);
      std::copy_n(u + i, n, columns.u + at_);
      std::copy_n(distance + i, n, columns.distance + at_);
      std::copy_n(prim + i, n, columns.prim + at_);
      if constexpr (at == At::surface) std::copy_n(t_out + i, n, columns.t_out + at_);
    };
    for (int from = first; from < end; from += kSimdWidth)
      if (rays.contiguous_fours[from / kSimdWidth])  // so all sixteen are rays: one that ends early repeats its last
        for (int i = from; i < from + kSimdWidth; i += 4) write(i, std::integral_constant<int, 4>());
      else
        for (int i = from; i < std::min(from + kSimdWidth, end); ++i) write(i, std::integral_constant<int, 1>());
  }
};

}  // namespace fastlines
