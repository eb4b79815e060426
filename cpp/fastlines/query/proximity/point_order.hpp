// The order in which points are answered: along a Morton curve, so that one point needs nodes that the last one has
// brought into the cache (Morton 1966).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "point_query.hpp"

namespace fastlines {

/// Sorts points by their place on a Morton curve through their box, ten bits an axis.
class PointOrder {
 public:
  /// The numbers of the points, counted from the first of them, in their order.
  const std::vector<std::uint32_t>& sorted(const double* coordinates, std::size_t n) {
    std::array<double, 3> low, high;
    low.fill(kInfinity);
    high.fill(-kInfinity);
    for (std::size_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], coordinates[3 * i + k]);
        high[k] = std::max(high[k], coordinates[3 * i + k]);
      }
    std::array<double, 3> scale;
    for (int k = 0; k < 3; ++k) scale[k] = high[k] > low[k] ? (kCells - 1) / (high[k] - low[k]) : 0.0;
    keys_.resize(n);
    order_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t key = 0;
      for (int k = 0; k < 3; ++k) key |= spread(std::uint32_t((coordinates[3 * i + k] - low[k]) * scale[k])) << k;
      keys_[i] = key;
      order_[i] = std::uint32_t(i);
    }
    for (int shift = 0; shift < 30; shift += kDigit) sort_by_digit(shift);
    return order_;
  }

 private:
  static constexpr int kDigit = 10;  // bits; three passes sort 30
  static constexpr double kCells = 1024.0;

  /// The low ten bits of a number, each in every third place.
  static std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 16) & 0x3000'00ff;
    x = (x | x << 8) & 0x0300'f00f;
    x = (x | x << 4) & 0x030c'30c3;
    return (x | x << 2) & 0x0924'9249;
  }

  /// One pass of a radix sort.
  void sort_by_digit(int shift) {
    std::array<std::uint32_t, (1 << kDigit) + 1> begin{};
    const auto digit = [&](std::uint32_t i) { return keys_[i] >> shift & ((1 << kDigit) - 1); };
    for (const std::uint32_t i : order_) ++begin[digit(i) + 1];
    for (int i = 0; i < 1 << kDigit; ++i) begin[i + 1] += begin[i];
    next_.resize(order_.size());
    for (const std::uint32_t i : order_) next_[begin[digit(i)]++] = i;
    order_.swap(next_);
  }

  std::vector<std::uint32_t> keys_, order_, next_;
};

}  // namespace fastlines
