// Hits of exact tests that a wavefront has not yet reported to the collector.
//
// The hits of one ray in one leaf are adjacent. For first hits, SIMD drops a hit if another hit of its ray, one or two
// places away, certainly precedes it. Each dropped hit saves a report that would change nothing, and a mispredicted
// branch.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "../../layout/wide_bvh.hpp"
#include "../collect/collector.hpp"

namespace fastlines {

struct PendingHitsTuning {
  /// Exact tests between two flushes. More tests give a mispredicted branch more work to overlap with; fewer stay in
  /// the L1 cache.
  static constexpr std::size_t kCapacity = 128;
};

template <class Collector>
class PendingHits {
 public:
  bool is_full() const { return n_ == kCapacity; }

  /// Append a packet of exact tests: the references, the lanes of their rays, the tie tolerances of these rays, the
  /// results, and a mask of those that hit.
  [[gnu::always_inline]] void add(const std::uint32_t* refs, const std::uint32_t* lane, FloatX16 tie_tolerance,
                                  const ClosestApproach<FloatX16>& approach, std::uint32_t hit) {
    if constexpr (Collector::kTraits.needs_position) {
      approach.s.store(s_ + n_);
      approach.dist2.store(dist2_ + n_);
      std::memcpy(refs_ + n_, refs, kSimdWidth * sizeof *refs);
      if constexpr (Collector::kTraits.drops_farther) {
        blend(hit, approach.t, kInfinity).store(t_ + kPadding + n_);
        tie_tolerance.store(tie_tolerance_ + n_);
        std::uint32_t ray_bits[kSimdWidth];  // a local array: for the compiler, `lane` may alias a member
        for (int i = 0; i < kSimdWidth; ++i) ray_bits[i] = lane[i] | kOneBits;
        std::memcpy(ray_ + kPadding + n_, ray_bits, sizeof ray_bits);
      } else {
        approach.t.store(t_ + kPadding + n_);
      }
    }
    std::memcpy(lane_ + n_, lane, kSimdWidth * sizeof *lane);
    if constexpr (Collector::kTraits.drops_farther)
      hit_[n_ / kSimdWidth] = hit;
    else
      list_hits(hit, n_);
    n_ += kSimdWidth;
  }

  /// Report the hits to the collector and clear.
  void flush(const WideRef* refs, const RayGroup& rays, Collector& collector) {
    if constexpr (Collector::kTraits.drops_farther) {
      if (collector.drops_farther())
        list_nearest_hits();
      else
        list_by_t();
    }
    for (std::size_t i = 0; i < n_hits_; ++i) {
      const std::uint32_t j = hits_[i];
      const int lane = int(lane_[j]);
      if constexpr (Collector::kTraits.needs_position)
        collector.add_hit(rays, lane, {s_[j], t_[kPadding + j], dist2_[j], true}, refs[refs_[j]]);
      else
        collector.add_hit(rays, lane, {}, {});
    }
    n_ = n_hits_ = 0;
  }

 private:
  static constexpr std::size_t kCapacity = PendingHitsTuning::kCapacity, kPadding = kSimdWidth;
  static constexpr std::uint32_t kOneBits = 0x3f80'0000;  // 1.0f: with it, the bits of a lane are a normal float

  void list_nearest_hits() {
    std::fill_n(t_ + kPadding + n_, kPadding, kInfinity);
    for (std::size_t at = 0; at < n_; at += kSimdWidth) list_hits(hit_[at / kSimdWidth] & nearest_mask(at), at);
  }

  /// List all hits, the nearest first: the collector then refuses most of the others by their t alone.
  void list_by_t() {
    for (std::size_t at = 0; at < n_; at += kSimdWidth) list_hits(hit_[at / kSimdWidth], at);
    const float* const t = t_ + kPadding;
    std::sort(hits_, hits_ + n_hits_, [=](std::uint32_t i, std::uint32_t j) { return t[i] < t[j]; });
  }

  void list_hits(std::uint32_t hit, std::size_t at) {
    compress_indices(hit, std::uint32_t(at), hits_ + n_hits_);
    n_hits_ += std::size_t(std::popcount(hit));
  }

  /// A mask of the tests of the packet at `at` that no neighbour of the same ray certainly precedes.
  [[gnu::always_inline]] std::uint32_t nearest_mask(std::size_t at) const {
    const float *const ts = t_ + kPadding + at, *const rays = ray_ + kPadding + at;
    const FloatX16 t = FloatX16::load(ts), ray = FloatX16::load(rays);
    FloatX16 least = t;
    for (const int shift : {-2, -1, 1, 2}) {
      const FloatX16 other_ray = FloatX16::load(rays + shift);
      const FloatX16 nearer = min(least, FloatX16::load(ts + shift));
      least = blend((other_ray <= ray) & (ray <= other_ray), nearer, least);
    }
    return may_precede(t, least, FloatX16::load(tie_tolerance_ + at)).bits();
  }

  std::size_t n_ = 0, n_hits_ = 0;  // tests, and hits that are listed
  alignas(64) float s_[kCapacity], dist2_[kCapacity], tie_tolerance_[kCapacity];
  // Padded at both ends, where neighbours are read. In front, 0.0f is the bits of no ray; behind, t is infinite, as for
  // a test that does not hit.
  alignas(64) float t_[kCapacity + 2 * kPadding] = {}, ray_[kCapacity + 2 * kPadding] = {};
  std::uint32_t refs_[kCapacity], lane_[kCapacity];
  std::uint32_t hit_[kCapacity / kSimdWidth];   // a mask for each packet
  std::uint32_t hits_[kCapacity + kSimdWidth];  // indices of the tests to report
};

}  // namespace fastlines
