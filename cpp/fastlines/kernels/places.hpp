// Sorting runs of numbers with hardly a branch that could be guessed wrong: a number's place is how many come before
// it. Long runs are dealt into buckets first, by a multiplication.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "../simd/simd.hpp"

namespace fastlines {

class Places {
 public:
  /// x[0 … n) takes the numbers; there is room to read and write up to the next multiple of 16.
  float* numbers(std::uint32_t n) {
    if (x_.size() < std::size_t(n) + kWidth) {
      x_.resize(2 * std::size_t(n) + kWidth);
      dealt_.resize(x_.size());
      place_.resize(x_.size());
      bucket_.resize(x_.size());
      from_.resize(x_.size());
    }
    return x_.data();
  }

  /// Where each number comes when all are sorted. Which of two equal numbers comes first is left open.
  const std::uint32_t* sort(std::uint32_t n) {
    std::fill_n(x_.data() + n, kWidth, std::numeric_limits<float>::infinity());
    if (n <= kFew)
      rank(x_.data(), n, 0, place_.data());
    else
      deal(n);
    return place_.data();
  }

 private:
  static constexpr std::uint32_t kFew = 2 * kWidth, kMany = 16 * kWidth, kBuckets = 256;

  /// The places of n numbers by counting. What follows them within sixteen is greater.
  static void rank(const float* x, std::uint32_t n, std::uint32_t first, std::uint32_t* place) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const Float16 mine = x[i];
      const std::uint32_t own = i / kWidth * kWidth, earlier = (1u << (i - own)) - 1;
      int before = 0;
      for (std::uint32_t j = 0; j < own; j += kWidth) before += std::popcount((Float16::load(x + j) <= mine).bits());
      const Float16 near = Float16::load(x + own);
      before += std::popcount((near < mine).bits() | ((near <= mine).bits() & earlier));
      for (std::uint32_t j = own + kWidth; j < n; j += kWidth)
        before += std::popcount((Float16::load(x + j) < mine).bits());
      place[i] = first + std::uint32_t(before);
    }
  }

  /// Deal into buckets in the order of the numbers, and sort each.
  void deal(std::uint32_t n) {
    float least = x_[0], most = x_[0];
    for (std::uint32_t i = 0; i < n; ++i) {
      least = min(least, x_[i]);
      most = max(most, x_[i]);
    }
    const std::uint32_t n_buckets = std::min(n / 8, kBuckets);
    const float per_bucket = float(n_buckets) / std::max(most - least, std::numeric_limits<float>::min());
    std::uint32_t begin[kBuckets + 1] = {}, next[kBuckets];
    for (std::uint32_t i = 0; i < n; ++i)
      bucket_[i] = std::uint32_t(min((x_[i] - least) * per_bucket, float(n_buckets - 1)));
    for (std::uint32_t i = 0; i < n; ++i) ++begin[bucket_[i] + 1];
    for (std::uint32_t b = 0; b < n_buckets; ++b) {
      next[b] = begin[b];
      begin[b + 1] += begin[b];
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t to = next[bucket_[i]]++;
      dealt_[to] = x_[i];
      from_[to] = i;
    }
    std::fill_n(dealt_.data() + n, kWidth, std::numeric_limits<float>::infinity());
    for (std::uint32_t b = 0; b < n_buckets; ++b) sort_bucket(begin[b], begin[b + 1]);
  }

  void sort_bucket(std::uint32_t begin, std::uint32_t end) {
    if (end - begin > kMany) {  // much the same number, or one far from all others
      const auto first = from_.begin() + begin, last = from_.begin() + end;
      std::sort(first, last, [&](std::uint32_t i, std::uint32_t j) { return x_[i] < x_[j]; });
      for (std::uint32_t i = begin; i < end; ++i) place_[from_[i]] = i;
      return;
    }
    std::uint32_t place[kMany];
    rank(dealt_.data() + begin, end - begin, begin, place);
    for (std::uint32_t i = begin; i < end; ++i) place_[from_[i]] = place[i - begin];
  }

  std::vector<float> x_, dealt_;
  std::vector<std::uint32_t> place_, bucket_, from_;
};

}  // namespace fastlines
