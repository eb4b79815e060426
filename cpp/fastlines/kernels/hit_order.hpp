// Puts the hits of sixteen rays in order: by ray, and by t but for those within 1/4096 of the range of all. A radix
// sort, for what comparisons guess wrong would cost more than all else that is done for a hit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lanes.hpp"

namespace fastlines {

class HitOrder {
 public:
  /// Sort hits 0 … n − 1, each of the ray in its lane, at t.
  void sort(const std::uint32_t* lane, const float* t, std::size_t n) {
    if (order_.size() < n)
      for (auto* numbers : {&order_, &by_low_, &key_}) numbers->resize(2 * n);
    make_keys(lane, t, n);
    if (n <= kFew)
      insert(n);
    else
      deal(n);
  }

  /// The numbers of the hits of the ray in this lane.
  std::span<const std::uint32_t> of(int lane) const {
    return {order_.data() + begin_[lane], begin_[lane + 1] - begin_[lane]};
  }

 private:
  static constexpr std::uint32_t kDigits = 256, kPerLane = kDigits / kWidth, kSteps = kPerLane * kDigits, kFew = 24;

  /// Lane and step of t in one number of two digits.
  void make_keys(const std::uint32_t* lane, const float* t, std::size_t n) {
    float least = std::numeric_limits<float>::max(), most = -least;
    for (std::size_t j = 0; j < n; ++j) {
      least = min(least, t[j]);
      most = max(most, t[j]);
    }
    const float per_t = float(kSteps - 1) / max(most - least, 0x1p-100f);
    for (std::size_t j = 0; j < n; ++j)
      key_[j] = lane[j] * kSteps + std::uint32_t(std::int32_t(min((t[j] - least) * per_t, float(kSteps - 1))));
  }

  void insert(std::size_t n) {
    for (std::uint32_t j = 0; j < n; ++j) {
      std::uint32_t to = j;
      for (; to > 0 && key_[j] < key_[order_[to - 1]]; --to) order_[to] = order_[to - 1];
      order_[to] = j;
    }
    std::uint32_t before = 0;
    for (std::uint32_t lane = 0; lane < kWidth; ++lane) {
      begin_[lane] = before;
      while (before < n && key_[order_[before]] / kSteps == lane) ++before;
    }
    begin_[kWidth] = before;
  }

  void deal(std::size_t n) {
    std::uint32_t low[kDigits] = {}, high[kDigits] = {};
    for (std::size_t j = 0; j < n; ++j) {
      ++low[key_[j] % kDigits];
      ++high[key_[j] / kDigits];
    }
    std::uint32_t before_low = 0, before_high = 0;
    for (std::uint32_t digit = 0; digit < kDigits; ++digit) {
      if (digit % kPerLane == 0) begin_[digit / kPerLane] = before_high;
      before_low += std::exchange(low[digit], before_low);
      before_high += std::exchange(high[digit], before_high);
    }
    begin_[kWidth] = before_high;
    for (std::uint32_t j = 0; j < n; ++j) by_low_[low[key_[j] % kDigits]++] = j;
    for (std::uint32_t j = 0; j < n; ++j) order_[high[key_[by_low_[j]] / kDigits]++] = by_low_[j];
  }

  std::vector<std::uint32_t> order_, by_low_, key_;
  std::uint32_t begin_[kWidth + 1];
};

}  // namespace fastlines
