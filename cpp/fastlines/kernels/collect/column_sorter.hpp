// Sorts 16 columns of integers at once with a sorting network. Two rows of 16 are compared lane by lane: the smaller
// integers go to one row, the larger to the other. The sequence of comparisons does not depend on the integers, so no
// branch is mispredicted.
//
// Up to 16 rows are sorted by the network of K. E. Batcher 1968, "Sorting networks and their applications", in as many
// registers as there are. More rows are merged as in Batcher's bitonic sorter.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "../../simd/float_x16.hpp"

namespace fastlines {

/// Sorts each of 16 columns in ascending order.
class ColumnSorter {
 public:
  /// The smallest sortable number of rows that is at least n: 4, 8, or a multiple of 16.
  static constexpr std::uint32_t rows_for(std::uint32_t n) {
    return n <= 8 ? std::max(4u, std::bit_ceil(n)) : (n + kSimdWidth - 1) / kSimdWidth * kSimdWidth;
  }

  /// An upper bound on the comparisons of two rows that sorting takes.
  static constexpr std::uint32_t n_comparisons(std::uint32_t n_rows) {
    const auto log = std::uint32_t(std::bit_width(n_rows - 1));
    return n_rows * log * (log + 1) / 4;
  }

  /// Sort `n_rows` rows of 16 integers in place. `n_rows` comes from `rows_for`.
  static void sort(std::uint32_t* table, std::uint32_t n_rows) {
    for (int part = 0; part < kSimdWidth; part += kPart) {
      std::uint32_t* const first = table + part;
      if (n_rows == 4)
        sort_few<4>(first);
      else if (n_rows == 8)
        sort_few<8>(first);
      else
        sort_many(first, n_rows);
    }
  }

 private:
  static constexpr int kPart = kSimdWidth / FloatX16::kRegisters;  // lanes of a row in one register
  using Row = std::uint32_t __attribute__((vector_size(kPart * sizeof(std::uint32_t))));
  /// Two rows to compare: the smaller integers go to a.
  struct Comparator {
    int a, b;
  };

  /// The comparators of a network that sorts n rows, or n rows whose columns are bitonic.
  template <int n, bool bitonic>
  static constexpr auto network() {
    constexpr auto list = [](auto&& add) {
      if (bitonic) {
        for (int step = n / 2; step > 0; step /= 2)
          for (int i = 0; i < n; ++i)
            if ((i & step) == 0) add(Comparator{i, i + step});
        return;
      }
      for (int p = 1; p < n; p *= 2)
        for (int k = p; k > 0; k /= 2)
          for (int j = k % p; j + k < n; j += 2 * k)
            for (int i = j; i < std::min(j + k, n - k); ++i)
              if (i / (2 * p) == (i + k) / (2 * p)) add(Comparator{i, i + k});
    };
    constexpr int size = [list] {
      int n_comparators = 0;
      list([&](Comparator) { ++n_comparators; });
      return n_comparators;
    }();
    std::array<Comparator, size> comparators{};
    int at = 0;
    list([&](Comparator comparator) { comparators[at++] = comparator; });
    return comparators;
  }

  static Row load(const std::uint32_t* from) {
    Row row;
    std::memcpy(&row, from, sizeof row);
    return row;
  }
  static void store(const Row& row, std::uint32_t* to) { std::memcpy(to, &row, sizeof row); }

  [[gnu::always_inline]] static void compare(Row& a, Row& b) {
    const Row smaller = a < b ? a : b;
    b = a < b ? b : a;
    a = smaller;
  }

  /// Sort up to 16 rows in registers.
  template <int n, bool bitonic = false>
  static void sort_few(std::uint32_t* first) {
    static constexpr auto comparators = network<n, bitonic>();
    Row rows[n];
    for (int i = 0; i < n; ++i) rows[i] = load(first + i * kSimdWidth);
    [&]<std::size_t... at>(std::index_sequence<at...>) __attribute__((always_inline)) {
      (compare(rows[comparators[at].a], rows[comparators[at].b]), ...);
    }(std::make_index_sequence<comparators.size()>());
    for (int i = 0; i < n; ++i) store(rows[i], first + i * kSimdWidth);
  }

  /// Of rows [part, end), compare those `2 * step` apart, then those `step` apart.
  static void merge_twice(std::uint32_t* first, std::uint32_t part, std::uint32_t step, std::uint32_t end) {
    const auto merge = [=]<int n>(std::integral_constant<int, n>, std::uint32_t i) __attribute__((always_inline)) {
      Row rows[n];
      for (std::uint32_t k = 0; k < n; ++k) rows[k] = load(first + (i + k * step) * kSimdWidth);
      for (int k = 0; k + 2 < n; ++k) compare(rows[k], rows[k + 2]);
      for (int k = 0; k + 1 < n; k += 2) compare(rows[k], rows[k + 1]);
      for (std::uint32_t k = 0; k < n; ++k) store(rows[k], first + (i + k * step) * kSimdWidth);
    };
    std::uint32_t i = part;
    for (; i < part + step && i + 3 * step < end; ++i) merge(std::integral_constant<int, 4>(), i);
    for (; i < part + step && i + 2 * step < end; ++i) merge(std::integral_constant<int, 3>(), i);
    for (; i < part + step && i + step < end; ++i) merge(std::integral_constant<int, 2>(), i);
  }

  /// Sort a multiple of 16 rows. The number of rows of a merged run is a power of two. Rows that the last run lacks
  /// would hold the largest integers and never move, so they are left out.
  static void sort_many(std::uint32_t* first, std::uint32_t n_rows) {
    const auto compare_rows = [=](std::uint32_t i, std::uint32_t j) {
      Row a = load(first + i * kSimdWidth), b = load(first + j * kSimdWidth);
      compare(a, b);
      store(a, first + i * kSimdWidth);
      store(b, first + j * kSimdWidth);
    };
    for (std::uint32_t i = 0; i < n_rows; i += kSimdWidth) sort_few<kSimdWidth>(first + i * kSimdWidth);
    for (std::uint32_t half = kSimdWidth; half < n_rows; half *= 2)  // merge runs of `half` rows
      for (std::uint32_t begin = 0; begin + half < n_rows; begin += 2 * half) {
        const std::uint32_t end = std::min(begin + 2 * half, n_rows);
        for (std::uint32_t j = begin + half; j < end; ++j) compare_rows(2 * (begin + half) - 1 - j, j);
        // Take two steps at once, so that rows are loaded and stored half as often.
        std::uint32_t step = half / 2;
        for (; step >= 2 * kSimdWidth; step /= 4)
          for (std::uint32_t part = begin; part < end; part += 2 * step) merge_twice(first, part, step / 2, end);
        if (step == kSimdWidth)
          for (std::uint32_t part = begin; part + step < end; part += 2 * step)
            for (std::uint32_t j = part + step; j < std::min(part + 2 * step, end); ++j) compare_rows(j - step, j);
        for (std::uint32_t i = begin; i < end; i += kSimdWidth) sort_few<kSimdWidth, true>(first + i * kSimdWidth);
      }
  }
};

}  // namespace fastlines
