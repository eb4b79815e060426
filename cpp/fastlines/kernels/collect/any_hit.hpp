// Finds whether each ray hits anything.
#pragma once

#include <bit>

#include "collector.hpp"

namespace fastlines {

/// Records one bit per ray, and ends the ray at its first hit.
template <class Where>
struct AnyHitCollector : Where {
  static constexpr QueryTraits kTraits{.needs_position = false};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  bool found[kGroupSize];

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(found + first, found + end, false);
  }

  void add_packet(const RayGroup&, int first, std::uint32_t hit, const ClosestApproach<FloatX16>&, std::uint32_t) {
    limit_changed |= hit != 0;
    for (; hit; hit &= hit - 1) {
      const int i = first + std::countr_zero(hit);
      found[i] = true;
      limit[i] = kNoMoreHits;
    }
  }

  void add_hit(const RayGroup&, int i, const ClosestApproach<float>&, const Reference&) {
    found[i] = true;
    limit[i] = kNoMoreHits;
  }
};

/// Writes whether each ray hits anything.
template <class Where = FixedAt<At::closest>>
struct AnyHitQuery {
  using Collector = AnyHitCollector<Where>;
  bool* to;  ///< one per ray of the batch

  Collector collector() const { return {}; }
  void store(const RayGroup& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.found[i];
  }
};

}  // namespace fastlines
