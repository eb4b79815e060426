// Rows of numbers that lie anywhere, turned in registers into vectors of what stands at the same place in each.
//
// To write them one by one into arrays and to read these as vectors would take several times as long: a vector can not
// be read before what it holds has left the processor's queue of stores.
#pragma once

#include <algorithm>

#include "simd.hpp"

namespace fastlines {

/// Four by four lanes, in each quarter of four vectors: what is first in them, what is second, and so on.
[[gnu::always_inline]] inline void turn_fours(const Float16 (&from)[4], Float16 (&to)[4]) {
  using F = Float16;
  const F first[2] = {F::of_fours<0, 1, 0, 1>(from[0], from[1]), F::of_fours<0, 1, 0, 1>(from[2], from[3])};
  const F last[2] = {F::of_fours<2, 3, 2, 3>(from[0], from[1]), F::of_fours<2, 3, 2, 3>(from[2], from[3])};
  to[0] = F::of_fours<0, 2, 0, 2>(first[0], first[1]);
  to[1] = F::of_fours<1, 3, 1, 3>(first[0], first[1]);
  to[2] = F::of_fours<0, 2, 0, 2>(last[0], last[1]);
  to[3] = F::of_fours<1, 3, 1, 3>(last[0], last[1]);
}

/// Of sixteen rows the four numbers from `at` on: the first of each, the second, and so on.
[[gnu::always_inline]] inline void turn_rows(const float* const (&rows)[16], int at, Float16 (&columns)[4]) {
  Float16 from[4];
  for (int i = 0; i < 4; ++i)
    from[i] = Float16::of_rows(rows[i] + at, rows[4 + i] + at, rows[8 + i] + at, rows[12 + i] + at);
  turn_fours(from, columns);
}

/// Sixteen rows of six numbers: the first of each, the second, and so on.
[[gnu::always_inline]] inline void turn_rows(const float* const (&rows)[16], Float16 (&columns)[6]) {
  Float16 first[4], last[4];
  turn_rows(rows, 0, first);
  turn_rows(rows, 2, last);
  std::copy_n(first, 4, columns);
  std::copy_n(last + 2, 2, columns + 4);
}

/// The other way: of n columns of sixteen numbers, the kth of which is `column(k)`, sixteen rows.
template <int n, class Row, class Column>
[[gnu::always_inline]] inline void turn_columns(const Column& column, Row* rows) {
  static_assert(n % 4 == 0 && n * sizeof(float) <= sizeof(Row));
  for (int k = 0; k < n; k += 4) {
    const Float16 from[4] = {Float16::load(column(k)), Float16::load(column(k + 1)), Float16::load(column(k + 2)),
                             Float16::load(column(k + 3))};
    Float16 turned[4];
    turn_fours(from, turned);
    const auto at = [=](int i) { return reinterpret_cast<float*>(rows + i) + k; };
    for (int i = 0; i < 4; ++i) turned[i].store_rows(at(i), at(4 + i), at(8 + i), at(12 + i));
  }
}

/// Sixteen points, four of which stand side by side at a time: their x, y and z.
[[gnu::always_inline]] inline void turn_points(const float* const (&fours)[4], Float16 (&xyz)[3]) {
  using F = Float16;
  F parts[3];  // x y z x, y z x y, and z x y z of each four points
  for (int k = 0; k < 3; ++k)
    parts[k] = F::of_rows(fours[0] + 4 * k, fours[1] + 4 * k, fours[2] + 4 * k, fours[3] + 4 * k);
  const F &a = parts[0], &b = parts[1], &c = parts[2];
  xyz[0] = F::of_fours<0, 3, 0, 2>(a, F::of_fours<2, 2, 1, 1>(b, c));
  xyz[1] = F::of_fours<0, 2, 0, 2>(F::of_fours<1, 1, 0, 0>(a, b), F::of_fours<3, 3, 2, 2>(b, c));
  xyz[2] = F::of_fours<0, 2, 0, 3>(F::of_fours<2, 2, 1, 1>(a, b), c);
}

}  // namespace fastlines
