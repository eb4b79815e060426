// Transposes between records in memory (AoS) and vectors of one field each (SoA), in registers.
//
// Writing the fields to arrays one by one and loading vectors from these takes several times as long. A vector load
// that spans several recent stores waits until these have left the store buffer.
#pragma once

#include <algorithm>
#include <utility>

#include "float_x16.hpp"

namespace fastlines {

/// Transposes four 4 × 4 matrices: one in each group of four lanes of the four vectors.
[[gnu::always_inline]] inline void transpose_4x4(const FloatX16 (&from)[4], FloatX16 (&to)[4]) {
  using F = FloatX16;
  const F first[2] = {F::shuffle<0, 1, 0, 1>(from[0], from[1]), F::shuffle<0, 1, 0, 1>(from[2], from[3])};
  const F last[2] = {F::shuffle<2, 3, 2, 3>(from[0], from[1]), F::shuffle<2, 3, 2, 3>(from[2], from[3])};
  to[0] = F::shuffle<0, 2, 0, 2>(first[0], first[1]);
  to[1] = F::shuffle<1, 3, 1, 3>(first[0], first[1]);
  to[2] = F::shuffle<0, 2, 0, 2>(last[0], last[1]);
  to[3] = F::shuffle<1, 3, 1, 3>(last[0], last[1]);
}

/// Columns at … at + 3 of 16 rows.
[[gnu::always_inline]] inline void transpose_rows(const float* const (&rows)[16], int at, FloatX16 (&columns)[4]) {
  FloatX16 from[4];
  for (int i = 0; i < 4; ++i)
    from[i] = FloatX16::of_rows(rows[i] + at, rows[4 + i] + at, rows[8 + i] + at, rows[12 + i] + at);
  transpose_4x4(from, columns);
}

/// The n ≥ 4 columns of 16 rows of n floats. Takes four columns at a time; the last four may overlap those before.
/// Unrolled by templates, because a loop would not keep the columns in registers.
template <std::size_t n>
[[gnu::always_inline]] inline void transpose_rows(const float* const (&rows)[16], FloatX16 (&columns)[n]) {
  static_assert(n >= 4);
  const auto four = [&]<std::size_t begin>(std::integral_constant<std::size_t, begin>) __attribute__((always_inline)) {
    constexpr std::size_t at = begin + 4 <= n ? begin : n - 4;
    FloatX16 found[4];
    transpose_rows(rows, int(at), found);
    std::copy_n(found + (begin - at), 4 - (begin - at), columns + begin);
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
    (four(std::integral_constant<std::size_t, 4 * i>()), ...);
  }(std::make_index_sequence<(n + 3) / 4>());
}

/// The inverse: writes 16 rows from n columns of 16 floats, where column(k) points to the k-th.
template <int n, class Row, class Column>
[[gnu::always_inline]] inline void transpose_columns(const Column& column, Row* rows) {
  static_assert(n % 4 == 0 && n * sizeof(float) <= sizeof(Row));
  for (int k = 0; k < n; k += 4) {
    const FloatX16 from[4] = {FloatX16::load(column(k)), FloatX16::load(column(k + 1)), FloatX16::load(column(k + 2)),
                              FloatX16::load(column(k + 3))};
    FloatX16 transposed[4];
    transpose_4x4(from, transposed);
    const auto at = [=](int i) { return reinterpret_cast<float*>(rows + i) + k; };
    for (int i = 0; i < 4; ++i) transposed[i].store_rows(at(i), at(4 + i), at(8 + i), at(12 + i));
  }
}

/// The x, y and z of 16 points; fours[i] points to points 4i … 4i + 3, packed.
[[gnu::always_inline]] inline void transpose_points(const float* const (&fours)[4], FloatX16 (&xyz)[3]) {
  using F = FloatX16;
  F parts[3];  // in each group of lanes: x y z x, y z x y, and z x y z of its four points
  for (int k = 0; k < 3; ++k)
    parts[k] = F::of_rows(fours[0] + 4 * k, fours[1] + 4 * k, fours[2] + 4 * k, fours[3] + 4 * k);
  const F &a = parts[0], &b = parts[1], &c = parts[2];
  xyz[0] = F::shuffle<0, 3, 0, 2>(a, F::shuffle<2, 2, 1, 1>(b, c));
  xyz[1] = F::shuffle<0, 2, 0, 2>(F::shuffle<1, 1, 0, 0>(a, b), F::shuffle<3, 3, 2, 2>(b, c));
  xyz[2] = F::shuffle<0, 2, 0, 3>(F::shuffle<2, 2, 1, 1>(a, b), c);
}

}  // namespace fastlines
