// Sorts sixteen columns of numbers at once, each on its own: rows of sixteen are compared with each other, the lesser
// numbers go to one and the greater to the other. Which rows these are does not depend on the numbers, so nothing is
// guessed. Up to sixteen rows are sorted by the network of K. E. Batcher 1968, "Sorting networks and their
// applications", in registers as far as there are enough; more by merging, as by his bitonic sorter.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "../simd/simd.hpp"

namespace fastlines {

class Columns {
 public:
  /// So many rows can be sorted: a power of two, 4 at least.
  static constexpr std::uint32_t rows_for(std::uint32_t n) { return std::max(4u, std::bit_ceil(n)); }

  /// A bound on how many comparisons of two rows that takes.
  static constexpr std::uint32_t n_comparisons(std::uint32_t n_rows) {
    const auto log = std::uint32_t(std::countr_zero(n_rows));
    return n_rows * log * (log + 1) / 4;
  }

  /// `numbers` are rows of sixteen.
  static void sort(std::uint32_t* numbers, std::uint32_t n_rows) {
    for (int part = 0; part < kWidth; part += kPart) {
      std::uint32_t* const first = numbers + part;
      if (n_rows == 4)
        sort_few<4>(first);
      else if (n_rows == 8)
        sort_few<8>(first);
      else
        sort_many(first, n_rows);
    }
  }

 private:
  static constexpr int kPart = kWidth / Float16::kRegisters;  // of a row: a register
  using Row = std::uint32_t __attribute__((vector_size(kPart * sizeof(std::uint32_t))));
  struct Pair {
    int a, b;
  };

  /// A network's comparisons. The sorter of n rows; or what puts a bitonic sequence of n in order.
  template <int n, bool bitonic>
  static constexpr auto network() {
    constexpr auto list = [](auto&& add) {
      if (bitonic) {
        for (int step = n / 2; step > 0; step /= 2)
          for (int i = 0; i < n; ++i)
            if ((i & step) == 0) add(Pair{i, i + step});
        return;
      }
      for (int p = 1; p < n; p *= 2)
        for (int k = p; k > 0; k /= 2)
          for (int j = k % p; j + k < n; j += 2 * k)
            for (int i = j; i < std::min(j + k, n - k); ++i)
              if (i / (2 * p) == (i + k) / (2 * p)) add(Pair{i, i + k});
    };
    constexpr int size = [list] {
      int n_pairs = 0;
      list([&](Pair) { ++n_pairs; });
      return n_pairs;
    }();
    std::array<Pair, size> pairs{};
    int at = 0;
    list([&](Pair pair) { pairs[at++] = pair; });
    return pairs;
  }

  static Row load(const std::uint32_t* from) {
    Row row;
    std::memcpy(&row, from, sizeof row);
    return row;
  }
  static void store(const Row& row, std::uint32_t* to) { std::memcpy(to, &row, sizeof row); }

  [[gnu::always_inline]] static void compare(Row& a, Row& b) {
    const Row less = a < b ? a : b;
    b = a < b ? b : a;
    a = less;
  }

  /// Up to sixteen rows.
  template <int n, bool bitonic = false>
  static void sort_few(std::uint32_t* first) {
    static constexpr auto pairs = network<n, bitonic>();
    Row rows[n];
    for (int i = 0; i < n; ++i) rows[i] = load(first + i * kWidth);
    [&]<std::size_t... at>(std::index_sequence<at...>) __attribute__((always_inline)) {
      (compare(rows[pairs[at].a], rows[pairs[at].b]), ...);
    }(std::make_index_sequence<pairs.size()>());
    for (int i = 0; i < n; ++i) store(rows[i], first + i * kWidth);
  }

  static void sort_many(std::uint32_t* first, std::uint32_t n_rows) {
    const auto compare_rows = [=](std::uint32_t i, std::uint32_t j) {
      Row a = load(first + i * kWidth), b = load(first + j * kWidth);
      compare(a, b);
      store(a, first + i * kWidth);
      store(b, first + j * kWidth);
    };
    for (std::uint32_t i = 0; i < n_rows; i += kWidth) sort_few<kWidth>(first + i * kWidth);
    for (std::uint32_t size = 2 * kWidth; size <= n_rows; size *= 2)  // of what is merged
      for (std::uint32_t begin = 0; begin < n_rows; begin += size) {
        for (std::uint32_t i = 0; i < size / 2; ++i) compare_rows(begin + i, begin + size - 1 - i);
        for (std::uint32_t step = size / 4; step >= kWidth; step /= 2)
          for (std::uint32_t part = begin; part < begin + size; part += 2 * step)
            for (std::uint32_t i = part; i < part + step; ++i) compare_rows(i, i + step);
        for (std::uint32_t i = begin; i < begin + size; i += kWidth) sort_few<kWidth, true>(first + i * kWidth);
      }
  }
};

}  // namespace fastlines
