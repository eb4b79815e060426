// Pieces that a wave has tested exactly, sixteen at a time, and of which it has not yet told what hits.
//
// A ray that meets several pieces of a leaf meets them beside each other. Where its first hit is wanted, those that lie
// surely behind another one or two places away are left out by vectors before any is told, for each costs a wrong
// guess.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "../collect/collector.hpp"

namespace fastlines {

template <class Collector>
class PendingHits {
 public:
  bool is_full() const { return n_ == kAtOnce; }

  /// Append sixteen: the references, the lanes of their rays and the margins of these, and which of them hit.
  [[gnu::always_inline]] void add(const std::uint32_t* what, const std::uint32_t* lane, FloatX16 tie_tolerance,
                                  const ClosestApproach<FloatX16>& approach, std::uint32_t hit) {
    if constexpr (Collector::kTraits.needs_position) {
      approach.s.store(s_ + n_);
      approach.dist2.store(dist2_ + n_);
      std::memcpy(what_ + n_, what, kSimdWidth * sizeof *what);
      if constexpr (Collector::kTraits.drops_farther) {
        blend(hit, approach.t, kNever).store(t_ + kRoom + n_);
        tie_tolerance.store(tie_tolerance_ + n_);
        std::uint32_t marks[kSimdWidth];  // of its own, for all the compiler knows `lane` lies in here
        for (int i = 0; i < kSimdWidth; ++i) marks[i] = lane[i] | kMark;
        std::memcpy(ray_ + kRoom + n_, marks, sizeof marks);
      } else {
        approach.t.store(t_ + kRoom + n_);
      }
    }
    std::memcpy(lane_ + n_, lane, kSimdWidth * sizeof *lane);
    if constexpr (Collector::kTraits.drops_farther)
      hit_[n_ / kSimdWidth] = hit;
    else
      list(hit, n_);
    n_ += kSimdWidth;
  }

  /// Show the collector what has hit, and forget all.
  void flush(const WideRef* refs, const RayGroup& rays, Collector& collector) {
    if constexpr (Collector::kTraits.drops_farther) list_nearest();
    for (std::size_t i = 0; i < n_hits_; ++i) {
      const std::uint32_t j = hits_[i];
      const int lane = int(lane_[j]);
      if constexpr (Collector::kTraits.needs_position)
        collector.add_hit(rays, lane, {s_[j], t_[kRoom + j], dist2_[j], true}, refs[what_[j]]);
      else
        collector.add_hit(rays, lane, {}, {});
    }
    n_ = n_hits_ = 0;
  }

 private:
  static constexpr std::size_t kAtOnce = 128, kRoom = kSimdWidth;
  static constexpr float kNever = std::numeric_limits<float>::infinity();
  static constexpr std::uint32_t kMark = 0x3f80'0000;  // so that the number of a lane is an ordinary float

  void list_nearest() {
    std::fill_n(t_ + kRoom + n_, kRoom, kNever);
    for (std::size_t at = 0; at < n_; at += kSimdWidth) list(hit_[at / kSimdWidth] & nearest(at), at);
  }

  void list(std::uint32_t hit, std::size_t at) {
    compress_indices(hit, std::uint32_t(at), hits_ + n_hits_);
    n_hits_ += std::size_t(std::popcount(hit));
  }

  /// Those of sixteen than which no neighbour of the same ray is surely nearer.
  [[gnu::always_inline]] std::uint32_t nearest(std::size_t at) const {
    const float *const t = t_ + kRoom + at, *const ray = ray_ + kRoom + at;
    const FloatX16 mine = FloatX16::load(t), me = FloatX16::load(ray);
    FloatX16 least = mine;
    for (const int beside : {-2, -1, 1, 2}) {
      const FloatX16 whose = FloatX16::load(ray + beside);
      least = blend((whose <= me) & (me <= whose), min(least, FloatX16::load(t + beside)), least);
    }
    return may_precede(mine, least, FloatX16::load(tie_tolerance_ + at)).bits();
  }

  std::size_t n_ = 0, n_hits_ = 0;
  alignas(64) float s_[kAtOnce], dist2_[kAtOnce], tie_tolerance_[kAtOnce];
  // With room before and behind, where neighbours are looked for: no ray's before, and behind t is infinite, as it is
  // where nothing hits.
  alignas(64) float t_[kAtOnce + 2 * kRoom] = {}, ray_[kAtOnce + 2 * kRoom] = {};
  std::uint32_t what_[kAtOnce], lane_[kAtOnce], hit_[kAtOnce / kSimdWidth], hits_[kAtOnce + kSimdWidth];
};

}  // namespace fastlines
