// Two concepts: a collector records the hits that a kernel reports for a group of 64 rays. A query writes what the
// collector has found to the caller's arrays.
//
// Each query has a file, which also holds its collector. A collector does in lanes what that of one ray, which defines
// the query, does (query/ray_collectors.hpp).
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>

#include "../../primitives/ray_primitive.hpp"
#include "../../query/ray_collectors.hpp"
#include "../rays/ray_group.hpp"

namespace fastlines {

/// What a traversal may assume of a collector.
struct QueryTraits {
  /// Hits may come in any order. Incoherent rays then go through a stream, which reports 16 pairs of a ray and a
  /// primitive at a time (`add_pairs`). Otherwise they go through a wavefront, which reports one hit at a time
  /// (`add_hit`).
  bool order_independent = false;
  /// Hits lower the limit, so the nearest node is visited first.
  bool shrinks_limit = false;
  /// The query needs t and the primitive of a hit. If not, a wavefront keeps only what the exact test reads of a ray.
  bool needs_position = true;
  /// A hit need not be reported if another one is nearer by more than the ray's tie tolerance, as long as
  /// `drops_farther()` of the collector is true.
  bool drops_farther = false;
};

/// Records the hits of a group of rays.
template <class C>
concept Collector = requires(C& collector, const RayGroup& rays, int lane, std::uint32_t bits, std::uint32_t prim,
                             const ClosestApproach<FloatX16>& approach) {
  { C::kTraits } -> std::convertible_to<QueryTraits>;
  /// Where t is taken, and which rays hit. Usually from `FixedAt`, `SurfaceAt` or `ChosenAt`.
  { collector.at } -> std::convertible_to<At>;
  /// Per lane, a t in the frame: hits beyond it may be reported, but the collector does not need them.
  { collector.limit } -> std::convertible_to<const float*>;
  /// Set when a limit falls. A collector with `tighten_limits(rays, first, end)` lowers limits only there.
  { collector.limit_changed } -> std::convertible_to<bool>;
  /// Prepare lanes [first, end). Lanes from `end` to the end of its packet have no ray; their limit excludes all hits.
  collector.begin(rays, lane, lane);
  /// Add the hits of the packet that begins at `lane` with one primitive: one bit per ray. Each primitive is reported
  /// once. `bits` is a subset of `approach.hit`.
  collector.add_packet(rays, lane, bits, approach, prim);
};

/// Writes what a collector has found. Each thread has a query of its own.
template <class Q>
concept Query = Collector<typename Q::Collector> &&
                requires(Q& query, typename Q::Collector& collector, const RayGroup& rays, int lane) {
                  /// An empty collector for this query.
                  { query.collector() } -> std::same_as<typename Q::Collector>;
                  /// Store the answers of the rays in lanes [first, end).
                  query.store(rays, collector, lane, lane);
                };

/// Set the limits of lanes [first, end) to those of the rays, and those of the lanes without a ray to `kNoMoreHits`.
inline void begin_limits(const RayGroup& rays, int first, int end, float (&limit)[kGroupSize]) {
  std::copy(rays.limit + first, rays.limit + end, limit + first);
  std::fill(limit + end, limit + round_up_to_width(end), kNoMoreHits);
}

/// Whether a hit at t may precede a hit at `best`, or tie with it, in units of the caller's ray. Both t are in the
/// frame.
template <class N>
auto may_precede(N t, N best, N tie_tolerance) {
  return t <= best + tie_tolerance;
}

/// The most hits in a block of a `HitBuffer`, which holds up to 64 rays. More would take over 40 GB.
inline constexpr std::size_t kMaxBlockHits = std::numeric_limits<std::int32_t>::max();

/// How many columns of a hit are stored.
constexpr std::uint32_t n_hit_columns(At at) { return has_exit(at) ? 5 : 4; }

/// One lane of a collector: the collector of one ray.
template <class C>
class CollectorLane {
 public:
  static constexpr bool kShrinksLimit = C::kTraits.shrinks_limit, kDropsFarther = C::kTraits.drops_farther;
  const At at;
  const float& limit;

  CollectorLane(const RayGroup& rays, int lane, C& collector)
      : at(collector.at), limit(collector.limit[lane]), rays_(rays), lane_(lane), collector_(collector) {}

  void add(const ClosestApproach<float>& approach, const Reference& ref) {
    collector_.add_hit(rays_, lane_, approach, ref);
  }

 private:
  const RayGroup& rays_;
  const int lane_;
  C& collector_;
};

}  // namespace fastlines
