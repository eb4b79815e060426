// Puts the hits of sixteen rays in order: by ray, and by t but for those that lie closest together. There is no branch
// on which of two hits comes first, for what is guessed wrong then costs more than all else that is done for a hit.
// Each ray's hits are a column of numbers, and all sixteen columns are sorted at once. Where that is too much, for a
// few rays have nearly all hits or one has very many, few hits are told their places by counting, and many are dealt
// out by the digits of their numbers.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "../../memory/large_vector.hpp"
#include "../rays/ray_group.hpp"
#include "column_sorter.hpp"

namespace fastlines {

class HitSorter {
 public:
  /// Sort hits 0 … n − 1, one at least, each of the ray in its lane, at t, of the segment prim.
  void sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    if (const std::size_t room = n + kMaxColumnHits; order_.size() < room)
      for (auto* numbers : {&order_, &place_, &key_}) numbers->resize(2 * room);
    const std::uint32_t most = find_begins(lane, n), n_rows = ColumnSorter::rows_for(most);
    if (n_rows <= kMaxColumnHits && ColumnSorter::n_comparisons(n_rows) <= kMaxComparisonsPerHit * n)
      sort_columns(t, prim, n, most, n_rows);
    else if (n <= kMaxCountedHits)
      counting_sort(lane, t, prim, n);
    else if (n <= 2048)
      radix_sort<8>(lane, t, prim, n);
    else
      radix_sort<11>(lane, t, prim, n);
  }

  /// The number of the hit that comes k-th.
  std::uint32_t operator[](std::size_t k) const { return order_[k]; }

  /// Where the hits of the ray in this lane begin; those of lane 16 would begin at n.
  std::uint32_t begin(int lane) const { return begin_[lane]; }

 private:
  static constexpr int kLaneBits = 4, kPrimBits = 4;
  static constexpr std::uint32_t kMaxColumnHits =
      512;  // hits of a ray: for more, to compare takes longer than to radix_sort out
  static constexpr std::uint32_t kMaxCountedHits = 256;      // hits of all rays: for more, so does to count
  static constexpr std::uint32_t kMaxComparisonsPerHit = 8;  // comparisons for each hit take as long

  /// Where the hits of each lane begin, and where each of a few stands in the columns; returns how many the lane of
  /// most has.
  std::uint32_t find_begins(const std::uint32_t* lane, std::uint32_t n) {
    std::uint32_t n_of[kSimdWidth] = {};
    std::uint32_t* const place = place_.data();
    for (std::uint32_t j = 0; j < n; ++j) place[j] = n_of[lane[j]]++ * kSimdWidth + lane[j];
    std::uint32_t most = 0;
    begin_[0] = 0;
    for (int i = 0; i < kSimdWidth; ++i) {
      most = std::max(most, n_of[i]);
      begin_[i + 1] = begin_[i] + n_of[i];
    }
    return most;
  }

  /// Keys: a step of t, and the end of the segment's number, for the pieces of a polyline are often met where they
  /// join, at the same t. Both in so many bits, below what comes first.
  template <class First>
  void make_keys(const float* t, const std::uint32_t* prim, std::uint32_t n, int bits, First&& first) {
    FloatX16 least16 = t[0], most16 = t[0];
    std::uint32_t j = 0;
    for (; j + kSimdWidth <= n; j += kSimdWidth) {
      least16 = min(least16, FloatX16::load(t + j));
      most16 = max(most16, FloatX16::load(t + j));
    }
    float from = reduce_min(least16), to = -reduce_min(FloatX16(0.0f) - most16);
    for (; j < n; ++j) {
      from = min(from, t[j]);
      to = max(to, t[j]);
    }
    const int step_bits = std::min(bits - kPrimBits, 24);  // as exact as floats are
    const float last = float((1 << step_bits) - 2);        // so that no key has all bits set
    const float per_t = last / max(to - from, 0x1p-100f);
    std::uint32_t* const key = key_.data();
    for (j = 0; j < n; ++j) {
      const auto step = std::uint32_t(std::int32_t(min((t[j] - from) * per_t, last)));
      key[j] = (((first(j) << step_bits) + step) << kPrimBits) + prim[j] % (1 << kPrimBits);
    }
  }

  /// Few hits: each comes after as many as have a lesser key, of which each ends in the number of its hit.
  void counting_sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    const int room_bits = std::bit_width(n - 1);
    make_keys(t, prim, n, 31 - kLaneBits - room_bits, [lane](std::uint32_t j) { return lane[j]; });
    std::int32_t keys[kMaxCountedHits + kSimdWidth];
    for (std::uint32_t j = 0; j < n; ++j) keys[j] = std::int32_t(key_[j] << room_bits | j);
    std::fill_n(keys + n, kSimdWidth, 0);  // read, though it does not count
    for (std::uint32_t first = 0; first < n; first += kSimdWidth) {
      std::int32_t n_before[kSimdWidth] = {};
      for (std::uint32_t i = 0; i < n; ++i)
        for (int k = 0; k < kSimdWidth; ++k) n_before[k] += keys[i] < keys[first + std::uint32_t(k)];
      for (std::uint32_t j = first; j < std::min(n, first + kSimdWidth); ++j)
        order_[std::size_t(n_before[j - first])] = j;
    }
  }

  /// Each lane's keys, ended by the numbers of the hits, are a column.
  void sort_columns(const float* t, const std::uint32_t* prim, std::uint32_t n, std::uint32_t most,
                    std::uint32_t n_rows) {
    const int room_bits = std::bit_width(n);
    make_keys(t, prim, n, 32 - room_bits, [](std::uint32_t) { return 0u; });
    std::fill_n(rows_, n_rows * kSimdWidth, ~0u);
    const std::uint32_t *const key = key_.data(), *const place = place_.data();
    for (std::uint32_t j = 0; j < n; ++j) rows_[place[j]] = (key[j] << room_bits) + j;
    ColumnSorter::sort(rows_, n_rows);
    write_columns((1u << room_bits) - 1, most);
  }

  /// ColumnSorter become runs, four rows at a time. A run is written to the end of the longest: what is too much lies
  /// where later lanes' runs begin, and is overwritten, for the last rows are written first, and later lanes after
  /// earlier ones. Beyond the last run there is room.
  void write_columns(std::uint32_t mask, std::uint32_t most) {
    std::uint32_t* const order = order_.data();
    const IntX4 bits = IntX4{} + std::int32_t(mask);
    for (std::uint32_t k = (most + 3) / 4 * 4; k > 0;) {
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

  /// Many hits: by each of three digits of their keys in turn, the last one first. A key goes with its hit, so that all
  /// are read one after the other.
  template <int digit_bits>
  void radix_sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
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
    Keyed *const first = first_.data(), *const second = second_.data();
    std::uint32_t* const order = order_.data();
    for (std::uint32_t j = 0; j < n; ++j) first[places[0][digit(key[j], 0)]++] = {key[j], j};
    for (std::uint32_t k = 0; k < n; ++k) second[places[1][digit(first[k].key, 1)]++] = first[k];
    for (std::uint32_t k = 0; k < n; ++k) order[places[2][digit(second[k].key, 2)]++] = second[k].hit;
  }

  struct Keyed {
    std::uint32_t key, hit;
  };
  LargeVector<std::uint32_t> order_, place_, key_;
  LargeVector<Keyed> first_, second_;
  std::uint32_t begin_[kSimdWidth + 1];
  alignas(64) std::uint32_t rows_[kMaxColumnHits * kSimdWidth];  // of the columns
};

}  // namespace fastlines
