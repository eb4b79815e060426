// What a kernel reports hits to: a collector records the hits of a group of 64 rays, and a query writes what a
// collector has found to the caller's arrays.
//
// There is a file for each query, with its collector. A collector does in lanes what a sink (query/sinks.hpp) does for
// one ray; the sinks are the definition.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>

#include "../../primitives/ray_primitive.hpp"
#include "../rays/ray_group.hpp"

namespace fastlines {

/// What a traversal may assume of a collector.
struct QueryTraits {
  /// Hits may come in any order, so incoherent rays go through a stream, which reports 16 pairs of a ray and a
  /// primitive at a time (`add_pairs`). Without it they go through a wavefront, which reports one hit at a time
  /// (`add_hit`).
  bool order_independent = false;
  /// Hits bring limits nearer, so the nearest node comes first.
  bool shrinks_limit = false;
  /// It matters what is hit, and where. Without it a wavefront keeps only what the exact test reads of a ray.
  bool needs_position = true;
  /// A hit need not be reported if another one is nearer by more than the tie tolerance of the ray.
  bool drops_farther = false;
};

template <class C>
concept Collector = requires(C& collector, const RayGroup& rays, int lane, std::uint32_t bits, std::uint32_t prim,
                             const ClosestApproach<FloatX16>& approach) {
  { C::kTraits } -> std::convertible_to<QueryTraits>;
  /// Where t is taken.
  { C::kAt } -> std::convertible_to<At>;
  /// Per lane: hits beyond this t of the frame are of no use, though they may be reported.
  { collector.limit } -> std::convertible_to<const float*>;
  /// Set where a limit falls. A collector with `tighten_limits(rays, first, end)` changes limits only there.
  { collector.limit_changed } -> std::convertible_to<bool>;
  /// Prepare lanes [first, end). Lanes from `end` to the end of its packet have no ray, and want no hits.
  collector.begin(rays, lane, lane);
  /// Hits of the packet that begins at a lane, one bit a ray, with one primitive, each primitive once. `bits` is a
  /// subset of `approach.hit`.
  collector.add_packet(rays, lane, bits, approach, prim);
};

template <class Q>
concept Query = Collector<typename Q::Collector> &&
                requires(Q& query, typename Q::Collector& collector, const RayGroup& rays, int lane) {
                  /// An empty collector for this query.
                  { query.collector() } -> std::same_as<typename Q::Collector>;
                  /// Store the answers of the rays in lanes [first, end). Each thread has a query of its own.
                  query.store(rays, collector, lane, lane);
                };

inline constexpr std::uint32_t kNoPrim = 0xffff'ffff;

/// Before every t: the limit of a ray that wants no more hits.
inline constexpr float kNoMoreHits = -std::numeric_limits<float>::max();

/// The limits of rays at the start.
inline void begin_limits(const RayGroup& rays, int first, int end, float (&limit)[kGroupSize]) {
  std::copy(rays.t_max + first, rays.t_max + end, limit + first);
  std::fill(limit + end, limit + round_up_to_width(end), kNoMoreHits);
}

/// Whether a hit at t may precede one at `best`, or tie with it, in the units of the caller's ray.
template <class N>
auto may_precede(N t, N best, N tie_tolerance) {
  return t <= best + tie_tolerance;
}

/// Hits of up to 64 rays in one block: more would take over 40 GB.
inline constexpr std::size_t kMaxBlockHits = std::numeric_limits<std::int32_t>::max();

/// How many columns are stored of a hit.
template <At at>
inline constexpr std::uint32_t kHitColumns = at == At::surface ? 5 : 4;

}  // namespace fastlines
