// Sums over all hits of each ray without listing them (query/gather/gather_rule.hpp). It sums what the collector of all
// hits keeps, so that kernels need not be compiled for it.
#pragma once

#include "../../query/gather/hit_summer.hpp"
#include "all_hits.hpp"

namespace fastlines {

/// Sums the hits of each ray.
template <AxisPrimitive P>
class GatherQuery {
 public:
  using Collector = AllHitsCollector;
  Checkpoint* checkpoint = nullptr;  ///< passed between the rays of a packet, if there is one

  GatherQuery(const WideBvhView<P>& tree, const RayBatch& batch, const GatherRule& rule, const GatherSums& to)
      : batch_(batch),
        rule_(rule),
        lines_{reinterpret_cast<const float*>(tree.items), sizeof(typename P::Item) / sizeof(float)},
        to_(to),
        summer_(rule) {}

  Collector collector() const { return Collector(At::closest); }

  void store(const RayGroup& rays, const Collector& found, int first, int end) {
    for (int i = first; i < end; i = (i / kSimdWidth + 1) * kSimdWidth)
      sum_packet(rays, i, std::min(end, (i / kSimdWidth + 1) * kSimdWidth), found.hits[i / kSimdWidth]);
  }

 private:
  /// Sum the hits of lanes [first, end), which belong to one packet.
  void sum_packet(const RayGroup& rays, int first, int end, const Collector::Hits& found) {
    std::size_t begin[kSimdWidth + 1];
    sort_by_lane(found, begin);
    for (int i = first; i < end; ++i) {
      if (checkpoint) checkpoint->check();
      const int lane = i % kSimdWidth;
      const std::size_t at = begin[lane], n = begin[lane + 1] - at;
      // Convert t and the distance to units of the caller's ray.
      float *const t = t_.data() + at, *const distance = distance_.data() + at;
      const float t_min = rays.t_min[i], t_max = rays.t_max[i];  // copied, since no store can alias them then
      const float t_min_ray = rays.t_min_ray[i], t_max_ray = rays.t_max_ray[i];
      for (std::size_t k = 0; k < n; ++k)
        t[k] = to_ray_t(t[k], t_min, t_max, t_min_ray, t_max_ray, rays.t0[i], rays.inv_scale, rays.inv_length[i]);
      for (std::size_t k = 0; k < n; ++k) distance[k] = float(std::sqrt(distance[k]) * rays.inv_scale);
      const std::uint32_t* const prim = prim_.data() + at;
      const std::size_t id = rays.id[i];
      summer_.sum(GatherRay(batch_[id], id, rule_), lines_, {t, u_.data() + at, distance, prim, prim, n},
                  to_.of_ray(id));
    }
  }

  /// Sort the hits of a packet by their rays; those of a lane begin at begin[lane].
  void sort_by_lane(const Collector::Hits& found, std::size_t (&begin)[kSimdWidth + 1]) {
    if (t_.size() < found.n) {
      for (auto* floats : {&t_, &u_, &distance_}) floats->resize(2 * found.n);
      prim_.resize(2 * found.n);
    }
    std::size_t next[kSimdWidth] = {};
    for (std::size_t j = 0; j < found.n; ++j) ++next[found.lane[j]];
    begin[0] = 0;
    for (int lane = 0; lane < kSimdWidth; ++lane) {
      begin[lane + 1] = begin[lane] + next[lane];
      next[lane] = begin[lane];
    }
    for (std::size_t j = 0; j < found.n; ++j) {
      const std::size_t to = next[found.lane[j]]++;
      t_[to] = found.t[j];
      u_[to] = found.s[j];
      distance_[to] = found.dist2[j];
      prim_[to] = found.prim[j];
    }
  }

  const RayBatch& batch_;
  const GatherRule& rule_;
  GatherLines lines_;
  GatherSums to_;
  HitSummer summer_;
  LargeVector<float> t_, u_, distance_;  // of a packet, by ray
  LargeVector<std::uint32_t> prim_;
};

}  // namespace fastlines
