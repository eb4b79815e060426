// Rows of numbers that lie anywhere, turned in registers into vectors of what stands at the same place in each.
//
// To write them one by one into arrays and to read these as vectors would take several times as long: a vector can not
// be read before what it holds has left the processor's queue of stores.
#pragma once

#include <algorithm>
#include <cstring>

#include "octets.hpp"
#include "simd.hpp"

namespace fastlines {

/// Of sixteen rows the four numbers from `at` on: the first of each, the second, and so on.
template <class F>
[[gnu::always_inline]] inline void turn_rows(const float* const (&rows)[16], int at, F (&columns)[4]) {
  if constexpr (F::kRegisters == 4) {
    for (int i = 0; i < 4; ++i) {
      Float4 from[4], to[4];
      for (int j = 0; j < 4; ++j) from[j] = four(rows[4 * i + j] + at);
      turn(from, to);
      for (int k = 0; k < 4; ++k) columns[k].v[i] = to[k];
    }
  } else {
    Octet eights[2][4];
    for (int half = 0; half < 2; ++half) {
      Float4 from[8];
      for (int j = 0; j < 8; ++j) from[j] = four(rows[8 * half + j] + at);
      turn(from, eights[half]);
    }
    for (int k = 0; k < 4; ++k) columns[k] = F::of(eights[0][k], eights[1][k]);
  }
}

/// Sixteen rows of six numbers: the first of each, the second, and so on.
template <class F>
[[gnu::always_inline]] inline void turn_rows(const float* const (&rows)[16], F (&columns)[6]) {
  F first[4], last[4];
  turn_rows(rows, 0, first);
  turn_rows(rows, 2, last);
  std::copy_n(first, 4, columns);
  std::copy_n(last + 2, 2, columns + 4);
}

/// The other way: of n columns of sixteen numbers, the kth of which is `column(k)`, sixteen rows.
template <int n, class Row, class Column>
[[gnu::always_inline]] inline void turn_columns(const Column& column, Row* rows) {
  static_assert(n % 4 == 0 && n * sizeof(float) <= sizeof(Row));
  for (int i = 0; i < 16; i += 4)
    for (int k = 0; k < n; k += 4) {
      const Float4 from[4] = {four(column(k) + i), four(column(k + 1) + i), four(column(k + 2) + i),
                              four(column(k + 3) + i)};
      Float4 turned[4];
      turn(from, turned);
      for (int j = 0; j < 4; ++j) std::memcpy(reinterpret_cast<float*>(rows + i + j) + k, &turned[j], sizeof turned[j]);
    }
}

/// Sixteen points, four of which stand side by side at a time: their x, y and z.
template <class F>
[[gnu::always_inline]] inline void turn_points(const float* const (&fours)[4], F (&xyz)[3]) {
  F parts[3];  // x y z x, y z x y, and z x y z of each four points
  for (int k = 0; k < 3; ++k) {
    Float4 part[4];
    for (int i = 0; i < 4; ++i) part[i] = four(fours[i] + 4 * k);
    if constexpr (F::kRegisters == 4)
      parts[k] = F(part[0], part[1], part[2], part[3]);
    else
      parts[k] = F::of(eight(part[0], part[1]), eight(part[2], part[3]));
  }
  const F &a = parts[0], &b = parts[1], &c = parts[2];
  xyz[0] = F::template of_fours<0, 3, 0, 2>(a, F::template of_fours<2, 2, 1, 1>(b, c));
  xyz[1] =
      F::template of_fours<0, 2, 0, 2>(F::template of_fours<1, 1, 0, 0>(a, b), F::template of_fours<3, 3, 2, 2>(b, c));
  xyz[2] = F::template of_fours<0, 2, 0, 3>(F::template of_fours<2, 2, 1, 1>(a, b), c);
}

}  // namespace fastlines
