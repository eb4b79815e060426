// What becomes of the hits of 64 rays. A kernel shows a collector, sixteen rays at a time, which of them come within
// their radius of a segment, if any: `take(rays, first, hit, approach, prim)`, each segment once. `limit` tells
// beyond which t of the frame a ray wants no more, though hits from there may be shown; where it falls, `closer` is
// set. If there is `bring_limits`, it falls only when that is called. `kAt` tells where hits are taken: s and t of an
// approach are of there. `approach.hit` may have lanes that `hit` has not. Where order matters, waves and searches of a
// single ray look at limits alone, and show one hit of one ray at a time, a segment again by each of its pieces:
// `take_one(rays, lane, approach, ref)`. `kNearestFirst` tells whether hits bring limits nearer, `kAsksWhere` whether
// it matters what is hit and where, and `kOnlyNearest` that hits need not be shown that lie behind another by more than
// the ray's margin. Of a ray that is not asked where, a wave has only what the exact test reads, its margin and its
// number.
//
// `begin` readies lanes [first, end); those from there to the end of their sixteen have no ray, and want nothing.
//
// The collectors here and in nearest.hpp do in lanes what the sinks of query/sinks.hpp do for one ray, which stay the
// definition.
#pragma once

#include <bit>

#include "../layout/wide.hpp"
#include "../memory/memory.hpp"
#include "lanes.hpp"

namespace fastlines {

inline constexpr std::uint32_t kNone = 0xffff'ffff;

/// Beyond every limit: what a ray that wants nothing more waits for.
inline constexpr float kOut = -std::numeric_limits<float>::max();

/// The limits of rays at the start.
inline void begin_limits(const RayLanes& rays, int first, int end, float (&limit)[kLanes]) {
  std::copy(rays.t_max + first, rays.t_max + end, limit + first);
  std::fill(limit + end, limit + past_sixteen(end), kOut);
}

/// Whether a hit at t may come before one at `best` as the caller counts, or be as near.
template <class N>
auto may_come_first(N t, N best, N margin) {
  return t <= best + margin;
}

/// The first hits.
template <At at_>
struct FirstCollector {
  static constexpr bool kUnordered = false, kNearestFirst = true, kAsksWhere = true, kOnlyNearest = true;
  static constexpr At kAt = at_;
  alignas(64) float limit[kLanes];
  bool closer = false;
  alignas(64) float t[kLanes], s[kLanes], dist2[kLanes], prim[kLanes];  // prim: the bits of an integer

  void begin(const RayLanes& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(t + first, t + past_sixteen(end), std::numeric_limits<float>::infinity());
    for (float* zero : {s, dist2}) std::fill(zero + first, zero + past_sixteen(end), 0.0f);  // read before it is known
    std::fill(prim + first, prim + past_sixteen(end), std::bit_cast<float>(kNone));
  }

  void take(const RayLanes& rays, int first, std::uint32_t hit, const Approach<Float16>& approach,
            std::uint32_t prim_) {
    const auto at = [first](float* x) { return Float16::load(x + first); };
    const Float16 margin = Float16::load(rays.margin + first), best = at(t);
    const Mask16 surely = approach.hit & (approach.t + margin < best);
    std::uint32_t unsure = hit & ~surely.bits() & may_come_first(approach.t, best, margin).bits();
    const auto set = [&](float* x, Float16 to) { select(surely, to, at(x)).store(x + first); };
    set(t, approach.t);
    set(s, approach.s);
    set(dist2, approach.dist2);
    set(prim, Float16(std::bit_cast<float>(prim_)));
    closer |= any(surely);
    for (; unsure; unsure &= unsure - 1) settle(rays, first, std::countr_zero(unsure), approach, prim_);
  }

  /// Bring the limits of rays [first, end) nearer, to what `take` has found: once for many of its calls.
  void bring_limits(const RayLanes& rays, int first, int end) {
    for (int i = first; i < end; i += kWidth)
      min(Float16::load(t + i) + Float16::load(rays.margin + i), Float16::load(limit + i)).store(limit + i);
  }

  /// The t of both are so near that they may be the same to the caller; then the lower id counts.
  void settle(const RayLanes& rays, int first, int lane, const Approach<Float16>& approach, std::uint32_t prim_) {
    alignas(64) float ts[kWidth], ss[kWidth], dist2s[kWidth];
    approach.t.store(ts);
    const int i = first + lane;
    if (!comes_first(rays, i, ts[lane], prim_)) return;
    approach.s.store(ss);
    approach.dist2.store(dist2s);
    set(rays, i, {ts[lane], ss[lane], dist2s[lane]}, prim_);
  }

  void take_one(const RayLanes& rays, int i, const Approach<float>& approach, const Reference& ref) {
    const float margin = rays.margin[i];
    if (!may_come_first(approach.t, t[i], margin)) return;
    if (approach.t + margin < t[i] || comes_first(rays, i, approach.t, ref.prim))
      set(rays, i, {approach.t, approach.s, approach.dist2}, ref.prim);
  }

 private:
  struct Place {
    float t, s, dist2;
  };

  /// Whether the caller counts this hit as the first.
  bool comes_first(const RayLanes& rays, int i, float t_, std::uint32_t prim_) const {
    const float given = rays.t_given(i, t_), best = rays.t_given(i, t[i]);
    return given < best || (given == best && prim_ < std::bit_cast<std::uint32_t>(prim[i]));
  }

  void set(const RayLanes& rays, int i, const Place& place, std::uint32_t prim_) {
    t[i] = place.t;
    s[i] = place.s;
    dist2[i] = place.dist2;
    prim[i] = std::bit_cast<float>(prim_);
    limit[i] = min(place.t + rays.margin[i], rays.t_max[i]);
    closer = true;
  }
};

struct AnyCollector {
  static constexpr bool kUnordered = false, kNearestFirst = false, kAsksWhere = false, kOnlyNearest = false;
  static constexpr At kAt = At::closest;
  alignas(64) float limit[kLanes];
  bool closer = false;
  bool found[kLanes];

  void begin(const RayLanes& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(found + first, found + end, false);
  }

  void take(const RayLanes&, int first, std::uint32_t hit, const Approach<Float16>&, std::uint32_t) {
    closer |= hit != 0;
    for (; hit; hit &= hit - 1) {
      const int i = first + std::countr_zero(hit);
      found[i] = true;
      limit[i] = kOut;
    }
  }

  void take_one(const RayLanes&, int i, const Approach<float>&, const Reference&) {
    found[i] = true;
    limit[i] = kOut;
  }
};

struct CountCollector {
  static constexpr bool kUnordered = true;
  static constexpr At kAt = At::closest;
  alignas(64) float limit[kLanes];
  bool closer = false;
  std::int64_t n_hits[kLanes];

  void begin(const RayLanes& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    std::fill(n_hits + first, n_hits + past_sixteen(end), 0);
  }

  void take(const RayLanes&, int first, std::uint32_t hit, const Approach<Float16>&, std::uint32_t) {
    for (; hit; hit &= hit - 1) ++n_hits[first + std::countr_zero(hit)];
  }

  /// The same for sixteen pairs: of a ray, counted from `first`, and a segment.
  void take_pairs(int first, std::uint32_t hit, const Approach<Float16>&, const std::uint32_t* ray, const Float16&) {
    for (; hit; hit &= hit - 1) ++n_hits[first + int(ray[std::countr_zero(hit)])];
  }
};

/// All hits, in no order; those of sixteen rays together, so that to sort them takes little memory.
template <At at_>
struct AllCollector {
  struct Hits {
    LargeVector<float> t, s, dist2;
    LargeVector<std::uint32_t> lane, prim;
    std::size_t n = 0;

    /// Append all but lane and prim, for which there is room then where they begin.
    std::size_t append(std::uint32_t hit, const Approach<Float16>& approach) {
      if (t.size() < n + 2 * kWidth) {
        for (auto* floats : {&t, &s, &dist2}) floats->resize(2 * n + 256);
        for (auto* numbers : {&lane, &prim}) numbers->resize(2 * n + 256);
      }
      pack(hit, approach.t, t.data() + n);
      pack(hit, approach.s, s.data() + n);
      pack(hit, approach.dist2, dist2.data() + n);
      const std::size_t before = n;
      n += std::size_t(std::popcount(hit));
      return before;
    }
  };

  static constexpr bool kUnordered = true;
  static constexpr At kAt = at_;
  alignas(64) float limit[kLanes];
  bool closer = false;
  Hits hits[kLanes / kWidth];

  void begin(const RayLanes& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    for (int i = first / kWidth; i < past_sixteen(end) / kWidth; ++i) hits[i].n = 0;
  }

  void take(const RayLanes&, int first, std::uint32_t hit, const Approach<Float16>& approach, std::uint32_t prim) {
    Hits& of = hits[first / kWidth];
    const std::size_t at = of.append(hit, approach);
    pack_numbers(hit, 0, of.lane.data() + at);
    std::fill_n(of.prim.data() + at, kWidth, prim);
  }

  /// The same for sixteen pairs: of a ray, counted from `first`, and a segment, of which the bits are given.
  void take_pairs(int first, std::uint32_t hit, const Approach<Float16>& approach, const std::uint32_t* ray,
                  const Float16& prims) {
    Hits& of = hits[first / kWidth];
    const std::size_t at = of.append(hit, approach);
    pack(hit, Float16::load(as_floats(ray)), reinterpret_cast<float*>(of.lane.data() + at));
    pack(hit, prims, reinterpret_cast<float*>(of.prim.data() + at));
  }
};

/// Test one piece against the ray in a lane, and show the collector if it hits.
template <class Collector>
[[gnu::always_inline]] inline void test_one(const WideView& tree, const RayLanes& rays, int lane, const Reference& ref,
                                            Collector& collector) {
  const RayInLane ray(rays, lane);
  const Seen<float> seen = see(ray, tree.segments[ref.prim], tree.frame);
  Approach<float> approach = closest_approach(ray, seen);
  if (!approach.hit) return;
  if constexpr (Collector::kAt == At::surface) approach = entry(ray, seen, approach);
  collector.take_one(rays, lane, approach, ref);
}

}  // namespace fastlines
