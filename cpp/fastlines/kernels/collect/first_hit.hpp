// Finds the first hit of each ray, or its first crossing of a primitive in pieces.
#pragma once

#include <bit>
#include <optional>

#include "../../memory/function_ref.hpp"
#include "../../rays/hit.hpp"
#include "collector.hpp"
#include "exit_points.hpp"
#include "first_crossings.hpp"

namespace fastlines {

/// Records the best hit of each lane; the limit falls with each nearer hit.
template <class Where>
struct FirstHitCollector : Where {
  static constexpr QueryTraits kTraits{.shrinks_limit = true, .drops_farther = true};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  alignas(64) float t[kGroupSize], s[kGroupSize], dist2[kGroupSize], prim[kGroupSize];  // prim: the bits of an id
  /// Whether a hit counts, by the id of the ray and the primitive. Without it, all do.
  using Filter = FunctionRef<bool(std::uint32_t, std::uint32_t)>;
  std::optional<Filter> filter;

  explicit FirstHitCollector(Where where = {}, std::optional<Filter> filter_ = {}) : Where(where), filter(filter_) {}

  /// Whether a hit that precedes others makes them needless: one that does not count does not.
  bool drops_farther() const { return !filter; }

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(t + first, t + round_up_to_width(end), kInfinity);
    // Rays without a hit read these too.
    for (float* column : {s, dist2}) std::fill(column + first, column + round_up_to_width(end), 0.0f);
    std::fill(prim + first, prim + round_up_to_width(end), std::bit_cast<float>(kNoPrim));
  }

  void add_packet(const RayGroup& rays, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                  std::uint32_t prim_) {
    if constexpr (Where::kHasExit)
      if (filter) return add_filtered(rays, first, hit, approach, prim_);
    const auto at = [first](float* x) { return FloatX16::load(x + first); };
    const FloatX16 tie_tolerance = FloatX16::load(rays.tie_tolerance + first), best = at(t);
    const MaskX16 nearer = approach.hit & (approach.t + tie_tolerance < best);
    std::uint32_t tied = hit & ~nearer.bits() & may_precede(approach.t, best, tie_tolerance).bits();
    const auto set = [&](float* x, FloatX16 to) { blend(nearer, to, at(x)).store(x + first); };
    set(t, approach.t);
    set(s, approach.s);
    set(dist2, approach.dist2);
    set(prim, FloatX16(std::bit_cast<float>(prim_)));
    limit_changed |= any(nearer);
    for (; tied; tied &= tied - 1) resolve_tie(rays, first, std::countr_zero(tied), approach, prim_);
  }

  /// Lower the limits of lanes [first, end) to the hits that `add_packet` has recorded: once for many of its calls.
  void tighten_limits(const RayGroup& rays, int first, int end) {
    for (int i = first; i < end; i += kSimdWidth)
      min(FloatX16::load(t + i) + FloatX16::load(rays.tie_tolerance + i), FloatX16::load(limit + i)).store(limit + i);
  }

  /// Compare a hit with the best one in units of the caller's ray. Both t in the frame are so close that they may round
  /// to the same t there; the lower id then precedes.
  void resolve_tie(const RayGroup& rays, int first, int lane, const ClosestApproach<FloatX16>& approach,
                   std::uint32_t prim_) {
    alignas(64) float ts[kSimdWidth], ss[kSimdWidth], dist2s[kSimdWidth];
    approach.t.store(ts);
    const int i = first + lane;
    if (!comes_first(rays, i, ts[lane], prim_)) return;
    approach.s.store(ss);
    approach.dist2.store(dist2s);
    set(rays, i, {ss[lane], ts[lane], dist2s[lane], true}, prim_);
  }

  void add_hit(const RayGroup& rays, int i, const ClosestApproach<float>& approach, const Reference& ref) {
    const float tie_tolerance = rays.tie_tolerance[i];
    if (!may_precede(approach.t, t[i], tie_tolerance)) return;
    if (!(approach.t + tie_tolerance < t[i] || comes_first(rays, i, approach.t, ref.prim))) return;
    if constexpr (Where::kHasExit)
      if (filter && !(*filter)(rays.id[i], ref.prim)) return;
    set(rays, i, approach, ref.prim);
  }

 private:
  void add_filtered(const RayGroup& rays, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                    std::uint32_t prim_) {
    alignas(64) float ts[kSimdWidth], ss[kSimdWidth], dist2s[kSimdWidth];
    approach.t.store(ts);
    approach.s.store(ss);
    approach.dist2.store(dist2s);
    for (; hit; hit &= hit - 1) {
      const int lane = std::countr_zero(hit);
      add_hit(rays, first + lane, {ss[lane], ts[lane], dist2s[lane], true}, Reference{prim_});
    }
  }

  /// Whether a hit precedes the best one of the lane, in units of the caller's ray.
  bool comes_first(const RayGroup& rays, int i, float t_, std::uint32_t prim_) const {
    const float t_ray = rays.t_ray(i, t_), best = rays.t_ray(i, t[i]);
    return precedes(t_ray, prim_, best, std::bit_cast<std::uint32_t>(prim[i]));
  }

  void set(const RayGroup& rays, int i, const ClosestApproach<float>& approach, std::uint32_t prim_) {
    t[i] = approach.t;
    s[i] = approach.s;
    dist2[i] = approach.dist2;
    prim[i] = std::bit_cast<float>(prim_);
    limit[i] = min(approach.t + rays.tie_tolerance[i], limit[i]);
    limit_changed = true;
  }
};

/// Writes the first hit of each ray.
template <RayPrimitive P, class Where>
struct FirstHitQuery {
  using Collector = FirstHitCollector<Where>;
  const WideBvhView<P>& tree;
  HitColumns to;  ///< one hit per ray of the batch
  Where where = {};
  /// Joins pieces, if primitives are in pieces; only where t is on the surface.
  mutable std::optional<FirstCrossings<P>> crossings = {};

  /// The collector, which this query outlives. The first piece whose surface a ray hits begins a crossing, but the
  /// first one that it enters may not.
  Collector collector() const {
    if (crossings && where.at == At::entry) return Collector(where, *crossings);
    return Collector(where);
  }

  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    constexpr Hit miss;
    float t[kGroupSize], u[kGroupSize], distance[kGroupSize], t_out[kGroupSize];
    std::int64_t prim[kGroupSize];
    const double inv_scale = rays.inv_scale;
    // Convert hits, 16 at a time. With a variable trip count or with branches, the loop would not be vectorised.
    for (int from = first; from < end; from += kSimdWidth)
      for (int i = from; i < from + kSimdWidth; ++i) {
        const auto id = std::bit_cast<std::uint32_t>(found.prim[i]);
        const bool hit = id != kNoPrim;
        const float t_ = rays.t_ray(i, found.t[i]), distance_ = float(std::sqrt(found.dist2[i]) * inv_scale);
        t[i] = hit ? t_ : miss.t;
        u[i] = hit ? found.s[i] : miss.u;
        distance[i] = hit ? distance_ : miss.distance;
        prim[i] = hit ? std::int64_t(id) : miss.prim;
      }
    if constexpr (Where::kHasExit)
      for (int from = first; from < end; from += kSimdWidth) store_exits_of_packet(tree, rays, found.prim, from, t_out);
    if constexpr (Where::kHasExit)
      if (crossings) store_extents(rays, prim, first, end, distance, t_out);
    const HitColumns columns = to;  // a copy, so that nothing written can alias it
    const auto write = [&](int i, auto n) __attribute__((always_inline)) {
      const std::uint32_t at_ = rays.id[i];
      std::copy_n(t + i, n, columns.t + at_);
      std::copy_n(u + i, n, columns.u + at_);
      std::copy_n(distance + i, n, columns.distance + at_);
      std::copy_n(prim + i, n, columns.prim + at_);
      if constexpr (Where::kHasExit) std::copy_n(t_out + i, n, columns.t_out + at_);
    };
    for (int from = first; from < end; from += kSimdWidth)
      if (rays.contiguous_fours[from / kSimdWidth])  // implies 16 different rays: a packet with fewer repeats its last
        for (int i = from; i < from + kSimdWidth; i += 4) write(i, std::integral_constant<int, 4>());
      else
        for (int i = from; i < std::min(from + kSimdWidth, end); ++i) write(i, std::integral_constant<int, 1>());
  }

 private:
  /// Write the distance and t_out of the crossings that begin with these pieces.
  void store_extents(const RayGroup& rays, const std::int64_t* prim, int first, int end, float* distance,
                     float* t_out) const {
    for (int i = first; i < end; ++i) {
      if (prim[i] < 0) continue;
      const Hit& crossing = crossings->first_with(rays.id[i], std::uint32_t(prim[i]));
      distance[i] = crossing.distance;
      t_out[i] = crossing.t_out;
    }
  }
};

}  // namespace fastlines
