// Counts the primitives that each ray hits.
#pragma once

#include <bit>

#include "all_hits.hpp"

namespace fastlines {

/// Records one count per ray.
struct CountHitsCollector : FixedAt<At::closest> {
  static constexpr QueryTraits kTraits{.order_independent = true, .needs_position = false};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  std::int64_t n_hits[kGroupSize];

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

  Collector collector() const { return {}; }
  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.n_hits[i];
  }
};

/// Writes how many primitives each ray enters. It counts what the collector of all hits keeps, so that kernels need not
/// be compiled for it.
struct CountEntriesQuery {
  using Collector = AllHitsCollector;
  std::int64_t* to;  ///< one per ray of the batch

  Collector collector() const { return Collector(At::entry); }
  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = 0;
    for (int from = first / kSimdWidth; from < round_up_to_width(end) / kSimdWidth; ++from)
      for (std::size_t j = 0; j < found.hits[from].n; ++j) {
        // Lanes behind the last ray repeat it. Where squares overflow, their limits do not keep all hits out.
        const int lane = from * kSimdWidth + int(found.hits[from].lane[j]);
        if (lane < end) ++to[rays.id[lane]];
      }
  }
};

}  // namespace fastlines
