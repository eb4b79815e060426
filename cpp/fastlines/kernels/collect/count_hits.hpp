// Counts the primitives that each ray hits.
#pragma once

#include <bit>

#include "collector.hpp"

namespace fastlines {

/// Records one count per ray.
struct CountHitsCollector : ChosenAt {
  static constexpr QueryTraits kTraits{.order_independent = true, .needs_position = false};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  std::int64_t n_hits[kGroupSize];

  explicit CountHitsCollector(At at_) : ChosenAt{at_} {}

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(n_hits + first, n_hits + round_up_to_width(end), 0);
  }

  void add_packet(const RayGroup&, int first, std::uint32_t hit, const ClosestApproach<FloatX16>&, std::uint32_t) {
    for (; hit; hit &= hit - 1) ++n_hits[first + std::countr_zero(hit)];
  }

  /// Add hits of 16 pairs: ray[i] is a lane counted from `first`.
  void add_pairs(int first, std::uint32_t hit, const ClosestApproach<FloatX16>&, const std::uint32_t* ray,
                 const FloatX16&) {
    for (; hit; hit &= hit - 1) ++n_hits[first + int(ray[std::countr_zero(hit)])];
  }
};

/// Writes how many primitives each ray hits.
struct CountHitsQuery {
  using Collector = CountHitsCollector;
  std::int64_t* to;  ///< one per ray of the batch
  At at = At::closest;

  Collector collector() const { return Collector(at); }
  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.n_hits[i];
  }
};

}  // namespace fastlines
