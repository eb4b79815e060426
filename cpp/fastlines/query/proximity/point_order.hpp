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
    std::array<std::array<std::uint32_t, kDigits + 1>, kPasses> begin{};  // where each digit begins, for each pass
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t key = 0;
      // The minimum is a cell even if boxes are so large or so small that the product is not a number.
      for (int k = 0; k < 3; ++k)
        key |= spread(std::uint32_t(std::min(kCells - 1, (coordinates[3 * i + k] - low[k]) * scale[k]))) << k;
      keys_[i] = std::uint64_t(key) << 32 | i;
      for (int pass = 0; pass < kPasses; ++pass) ++begin[pass][digit(keys_[i], pass) + 1];
    }
    // Sort by one digit after the other.
    next_.resize(n);
    for (int pass = 0; pass < kPasses; ++pass) {
      for (int i = 0; i < kDigits; ++i) begin[pass][i + 1] += begin[pass][i];
      for (const std::uint64_t key : keys_) next_[begin[pass][digit(key, pass)]++] = key;
      keys_.swap(next_);
    }
    order_.resize(n);
    for (std::size_t i = 0; i < n; ++i) order_[i] = std::uint32_t(keys_[i]);
    return order_;
  }

 private:
  static constexpr int kPasses = 3, kBits = 10, kDigits = 1 << kBits;  // 30 bits in all
  static constexpr double kCells = 1024.0;

  /// A digit of a key, whose high half is the place on the curve, and its low half the number of the point.
  static std::size_t digit(std::uint64_t key, int pass) { return key >> (32 + pass * kBits) & (kDigits - 1); }

  /// The low ten bits of a number, each in every third place.
  static std::uint32_t spread(std::uint32_t x) {
    x = (x | x << 16) & 0x3000'00ff;
    x = (x | x << 8) & 0x0300'f00f;
    x = (x | x << 4) & 0x030c'30c3;
    return (x | x << 2) & 0x0924'9249;
  }

  std::vector<std::uint64_t> keys_, next_;
  std::vector<std::uint32_t> order_;
};

}  // namespace fastlines
