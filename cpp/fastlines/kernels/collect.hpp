// What becomes of the hits of 64 rays. A kernel shows a collector, sixteen rays at a time, which of them come within
// their radius of a segment, if any: `take(rays, first, hit, approach, prim)`, each segment once. `approach.hit`
// may have lanes that `hit` has not: true hits as well, of rays for which the segment was not looked for. `limit` tells
// beyond which t of the frame a ray wants no more; where it falls, `closer` is set.
//
// The collectors here do in lanes what the sinks of query/sinks.hpp do for one ray, which stay the definition: where
// rounding could decide, and for what is asked for less often, they are asked.
#pragma once

#include <bit>

#include "../layout/wide.hpp"
#include "lanes.hpp"

namespace fastlines {

inline constexpr std::uint32_t kNone = 0xffff'ffff;

/// Beyond every limit: what a ray that wants nothing more waits for.
inline constexpr float kOut = -std::numeric_limits<float>::max();

/// The limits of rays at the start; lanes without a ray want nothing.
inline void begin_limits(const RayLanes& rays, float (&limit)[kLanes]) {
  for (int i = 0; i < kLanes; ++i) limit[i] = i < rays.n ? rays.t_max[i] : kOut;
}

/// Any sink, for each ray on its own.
template <class Sink>
struct SinkCollector {
  static constexpr bool kUnordered = false;
  alignas(64) float limit[kLanes];
  bool closer = false;
  const WideView& tree;
  std::vector<Sink> sinks;

  explicit SinkCollector(const WideView& tree_) : tree(tree_) {}

  template <class Make>
  void begin(const RayLanes& rays, Make&& make) {
    begin_limits(rays, limit);
    sinks.clear();
    for (int i = 0; i < rays.n; ++i) sinks.push_back(make(i));
  }

  void take(const RayLanes& rays, int first, std::uint32_t hit, const Approach<Float16>&, std::uint32_t prim) {
    for (; hit; hit &= hit - 1) {
      const int i = first + std::countr_zero(hit);
      if (i >= rays.n) return;
      const Ray ray = rays.ray(i);
      test_segment(ray, tree.segments[prim], tree.frame, Reference{prim}, sinks[std::size_t(i)]);
      const float now = sinks[std::size_t(i)].done() ? kOut : sinks[std::size_t(i)].limit;
      closer |= now < limit[i];
      limit[i] = now;
    }
  }
};

/// The first hits, by closest approach.
struct FirstCollector {
  static constexpr bool kUnordered = false;
  alignas(64) float limit[kLanes];
  bool closer = false;
  alignas(64) float t[kLanes], s[kLanes], dist2[kLanes], prim[kLanes];  // prim: the bits of an integer

  void begin(const RayLanes& rays) {
    begin_limits(rays, limit);
    std::fill_n(t, kLanes, std::numeric_limits<float>::infinity());
    std::fill_n(prim, kLanes, std::bit_cast<float>(kNone));
  }

  void take(const RayLanes& rays, int first, std::uint32_t hit, const Approach<Float16>& approach,
            std::uint32_t prim_) {
    const auto at = [first](float* x) { return Float16::load(x + first); };
    const Float16 margin = Float16::load(rays.margin + first), best = at(t);
    const Mask16 surely = approach.hit & (approach.t + margin < best);
    std::uint32_t unsure = hit & ~surely.bits() & (approach.t <= best + margin).bits();
    const auto set = [&](float* x, Float16 to) { select(surely, to, at(x)).store(x + first); };
    set(t, approach.t);
    set(s, approach.s);
    set(dist2, approach.dist2);
    set(prim, Float16(std::bit_cast<float>(prim_)));
    set(limit, min(approach.t + margin, Float16::load(rays.t_max + first)));
    closer |= any(surely);
    for (; unsure; unsure &= unsure - 1) settle(rays, first, std::countr_zero(unsure), approach, prim_);
  }

  /// The t of both are so near that they may be the same to the caller; then the lower id counts.
  void settle(const RayLanes& rays, int first, int lane, const Approach<Float16>& approach, std::uint32_t prim_) {
    alignas(64) float ts[kWidth], ss[kWidth], dist2s[kWidth];
    approach.t.store(ts);
    const int i = first + lane;
    if (i >= rays.n) return;
    const Ray ray = rays.ray(i);
    const float given = ray.t_given(ts[lane]), best = ray.t_given(t[i]);
    if (!(given < best || (given == best && prim_ < std::bit_cast<std::uint32_t>(prim[i])))) return;
    approach.s.store(ss);
    approach.dist2.store(dist2s);
    t[i] = ts[lane];
    s[i] = ss[lane];
    dist2[i] = dist2s[lane];
    prim[i] = std::bit_cast<float>(prim_);
    limit[i] = min(t[i] + ray.margin, ray.t_max);
    closer = true;
  }
};

struct AnyCollector {
  static constexpr bool kUnordered = false;
  alignas(64) float limit[kLanes];
  bool closer = false;
  bool found[kLanes];

  void begin(const RayLanes& rays) {
    begin_limits(rays, limit);
    std::fill_n(found, kLanes, false);
  }

  void take(const RayLanes&, int first, std::uint32_t hit, const Approach<Float16>&, std::uint32_t) {
    closer |= hit != 0;
    for (; hit; hit &= hit - 1) {
      const int i = first + std::countr_zero(hit);
      found[i] = true;
      limit[i] = kOut;
    }
  }
};

struct CountCollector {
  static constexpr bool kUnordered = true;
  alignas(64) float limit[kLanes];
  bool closer = false;
  std::int64_t n_hits[kLanes];

  void begin(const RayLanes& rays) {
    begin_limits(rays, limit);
    std::fill_n(n_hits, kLanes, 0);
  }

  void take(const RayLanes&, int first, std::uint32_t hit, const Approach<Float16>&, std::uint32_t) {
    for (; hit; hit &= hit - 1) ++n_hits[first + std::countr_zero(hit)];
  }

  /// The same for sixteen pairs: of a ray, counted from `first`, and a segment.
  void take_pairs(int first, std::uint32_t hit, const Approach<Float16>&, const std::uint32_t* ray, const Float16&) {
    for (; hit; hit &= hit - 1) ++n_hits[first + int(ray[std::countr_zero(hit)])];
  }
};

/// All hits, by closest approach, in no order; those of sixteen rays together, so that to sort them takes little
/// memory.
struct AllCollector {
  struct Hits {
    std::vector<float> t, s, dist2;
    std::vector<std::uint32_t> lane, prim;
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
  alignas(64) float limit[kLanes];
  bool closer = false;
  Hits hits[kLanes / kWidth];

  void begin(const RayLanes& rays) {
    begin_limits(rays, limit);
    for (Hits& of : hits) of.n = 0;
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

}  // namespace fastlines
