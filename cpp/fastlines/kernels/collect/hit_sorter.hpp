// Sorts the hits of 16 rays by ray, then by t. Hits whose t are closest together may stay out of order.
//
// No branch depends on the order of two hits: a mispredicted branch costs more than all other work for a hit.
// The hits of a ray are a column of integer keys, and a sorting network sorts all 16 columns at once. That takes too
// long if a few rays have nearly all hits, or one ray has very many. A counting sort then serves few hits, a radix sort
// many.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "../../memory/large_vector.hpp"
#include "../../parallel/progress.hpp"
#include "../rays/ray_group.hpp"
#include "column_sorter.hpp"

namespace fastlines {

/// The limits between the methods of `HitSorter`.
struct HitSorterTuning {
  /// The most hits of one ray for which a sorting network is faster than a radix sort.
  static constexpr std::uint32_t kMaxColumnHits = 512;
  /// The most comparisons of two rows per hit for which a sorting network is the fastest method.
  static constexpr std::uint32_t kMaxComparisonsPerHit = 8;
  /// The most hits of all rays for which a counting sort is faster than a radix sort.
  static constexpr std::uint32_t kMaxCountedHits = 256;
  /// The most hits of all rays for which a radix sort takes digits of 8 bits. Digits of 11 bits need larger tables.
  static constexpr std::uint32_t kMaxByteDigitHits = 2048;
};

/// Sorts the hits of a packet. Reuses its memory.
class HitSorter {
  using Tuning = HitSorterTuning;

 public:
  /// Sort hits 0 … n − 1, n ≥ 1. Hit j is of the ray in lane[j], at t[j], with primitive prim[j]. A long sort passes
  /// the checkpoint, if there is one.
  void sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n,
            Checkpoint* checkpoint = nullptr) {
    if (const std::size_t room = n + Tuning::kMaxColumnHits; order_.size() < room)
      for (auto* indices : {&order_, &place_, &key_}) indices->resize(2 * room);
    const std::uint32_t longest = find_begins(lane, n), n_rows = ColumnSorter::rows_for(longest);
    if (n_rows <= Tuning::kMaxColumnHits && ColumnSorter::n_comparisons(n_rows) <= Tuning::kMaxComparisonsPerHit * n)
      sort_columns(t, prim, n, longest, n_rows);
    else if (n <= Tuning::kMaxCountedHits)
      counting_sort(lane, t, prim, n);
    else if (n <= Tuning::kMaxByteDigitHits)
      radix_sort<8>(lane, t, prim, n, nullptr);
    else
      radix_sort<11>(lane, t, prim, n, checkpoint);
  }

  /// The index of the hit that comes k-th.
  std::uint32_t operator[](std::size_t k) const { return order_[k]; }

  /// Where the sorted hits of the ray in this lane begin; begin(16) = n.
  std::uint32_t begin(int lane) const { return begin_[lane]; }

 private:
  static constexpr int kLaneBits = 4, kPrimBits = 4;

  /// Find where the hits of each lane begin, and the place of each hit in the columns, which counts only if the columns
  /// are sorted. Returns the number of hits of the lane that has the most.
  std::uint32_t find_begins(const std::uint32_t* lane, std::uint32_t n) {
    std::uint32_t n_of[kSimdWidth] = {};
    std::uint32_t* const place = place_.data();
    for (std::uint32_t j = 0; j < n; ++j) place[j] = n_of[lane[j]]++ * kSimdWidth + lane[j];
    std::uint32_t longest = 0;
    begin_[0] = 0;
    for (int i = 0; i < kSimdWidth; ++i) {
      longest = std::max(longest, n_of[i]);
      begin_[i + 1] = begin_[i] + n_of[i];
    }
    return longest;
  }

  /// Make keys: first(j), then t quantised to steps, then the low bits of the primitive's id. A ray often hits two
  /// segments of a polyline at their joint, at the same t. Step and id take `bits` bits together.
  template <class First>
  void make_keys(const float* t, const std::uint32_t* prim, std::uint32_t n, int bits, First&& first) {
    FloatX16 least16 = t[0], most16 = t[0];
    std::uint32_t j = 0;
    for (; j + kSimdWidth <= n; j += kSimdWidth) {
      least16 = min(least16, FloatX16::load(t + j));
      most16 = max(most16, FloatX16::load(t + j));
    }
    float from = reduce_min(least16), to = reduce_max(most16);
    for (; j < n; ++j) {
      from = min(from, t[j]);
      to = max(to, t[j]);
    }
    const int step_bits = std::min(bits - kPrimBits, 24);  // as precise as a float
    const float last = float((1 << step_bits) - 2);        // so that no key has all bits set
    const float per_t = last / max(to - from, 0x1p-100f);
    std::uint32_t* const key = key_.data();
    for (j = 0; j < n; ++j) {
      const auto step = std::uint32_t(std::int32_t(min((t[j] - from) * per_t, last)));
      key[j] = (((first(j) << step_bits) + step) << kPrimBits) + prim[j] % (1 << kPrimBits);
    }
  }

  /// Counting sort: the place of a hit is the number of smaller keys. A key ends in the index of its hit, so that all
  /// keys differ.
  void counting_sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    const int index_bits = std::bit_width(n - 1);
    make_keys(t, prim, n, 31 - kLaneBits - index_bits, [lane](std::uint32_t j) { return lane[j]; });
    std::int32_t keys[Tuning::kMaxCountedHits + kSimdWidth];
    for (std::uint32_t j = 0; j < n; ++j) keys[j] = std::int32_t(key_[j] << index_bits | j);
    std::fill_n(keys + n, kSimdWidth, 0);  // read, but not used
    for (std::uint32_t first = 0; first < n; first += kSimdWidth) {
      std::int32_t n_before[kSimdWidth] = {};
      for (std::uint32_t i = 0; i < n; ++i)
        for (int k = 0; k < kSimdWidth; ++k) n_before[k] += keys[i] < keys[first + std::uint32_t(k)];
      for (std::uint32_t j = first; j < std::min(n, first + kSimdWidth); ++j)
        order_[std::size_t(n_before[j - first])] = j;
    }
  }

  /// Sorting network: each lane's keys, which end in the indices of the hits, are a column.
  void sort_columns(const float* t, const std::uint32_t* prim, std::uint32_t n, std::uint32_t longest,
                    std::uint32_t n_rows) {
    const int index_bits = std::bit_width(n);
    make_keys(t, prim, n, 32 - index_bits, [](std::uint32_t) { return 0u; });
    std::fill_n(rows_, n_rows * kSimdWidth, ~0u);
    const std::uint32_t *const key = key_.data(), *const place = place_.data();
    for (std::uint32_t j = 0; j < n; ++j) rows_[place[j]] = (key[j] << index_bits) + j;
    ColumnSorter::sort(rows_, n_rows);
    write_columns((1u << index_bits) - 1, longest);
  }

  /// Transpose columns to runs, four rows at a time. Each run is written as long as the longest one. What is written
  /// past its end lies in the runs of later lanes and is overwritten: the last rows are written first, and later lanes
  /// after earlier ones. There is room past the last run.
  void write_columns(std::uint32_t mask, std::uint32_t longest) {
    std::uint32_t* const order = order_.data();
    const IntX4 bits = IntX4{} + std::int32_t(mask);
    for (std::uint32_t k = (longest + 3) / 4 * 4; k > 0;) {
      k -= 4;
      for (int first = 0; first < kSimdWidth; first += 4) {
        FloatX4 rows[4], columns[4];
        for (std::uint32_t i = 0; i < 4; ++i) {
          IntX4 row;
          std::memcpy(&row, rows_ + (k + i) * kSimdWidth + first, sizeof row);
          rows[i] = FloatX4(row & bits);
        }
        transpose(rows, columns);
        for (int i = 0; i < 4; ++i) std::memcpy(order + begin_[first + i] + k, &columns[i], sizeof columns[i]);
      }
    }
  }

  /// Radix sort by three digits of the keys, the lowest first. A key moves with its hit, so that reads are sequential.
  template <int digit_bits>
  void radix_sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n,
                  Checkpoint* checkpoint) {
    constexpr int n_digits = 3;
    constexpr std::uint32_t n_values = 1 << digit_bits;
    make_keys(t, prim, n, std::min(n_digits * digit_bits, 32) - kLaneBits, [lane](std::uint32_t j) { return lane[j]; });
    const auto digit = [](std::uint32_t key, int i) { return key >> digit_bits * i & (n_values - 1); };
    std::uint32_t places[n_digits][n_values] = {}, before[n_digits] = {};
    for (std::uint32_t j = 0; j < n; ++j)
      for (int i = 0; i < n_digits; ++i) ++places[i][digit(key_[j], i)];
    for (std::uint32_t value = 0; value < n_values; ++value)
      for (int i = 0; i < n_digits; ++i) before[i] += std::exchange(places[i][value], before[i]);
    if (first_.size() < n)
      for (auto* hits : {&first_, &second_}) hits->resize(2 * std::size_t(n));
    const std::uint32_t* const key = key_.data();
    KeyedHit *const first = first_.data(), *const second = second_.data();
    std::uint32_t* const order = order_.data();
    for_each_index(n, checkpoint, [&](std::uint32_t j) { first[places[0][digit(key[j], 0)]++] = {key[j], j}; });
    for_each_index(n, checkpoint, [&](std::uint32_t k) { second[places[1][digit(first[k].key, 1)]++] = first[k]; });
    for_each_index(n, checkpoint,
                   [&](std::uint32_t k) { order[places[2][digit(second[k].key, 2)]++] = second[k].hit; });
  }

  /// A key and the index of its hit.
  struct KeyedHit {
    std::uint32_t key, hit;
  };
  LargeVector<std::uint32_t> order_, place_, key_;
  LargeVector<KeyedHit> first_, second_;
  std::uint32_t begin_[kSimdWidth + 1];
  alignas(64) std::uint32_t rows_[Tuning::kMaxColumnHits * kSimdWidth];  // of keys: a column per lane
};

}  // namespace fastlines
