// Four lanes of float32 or float64 in the compiler's vector types. A point has lane 3 as padding.
//
// Every operation but `fma` gives the same bits on every instruction set.
#pragma once

#include <cstdint>
#include <cstring>

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace fastlines {

using FloatX4 = float __attribute__((vector_size(16)));
using DoubleX2 = double __attribute__((vector_size(16)));
using DoubleX4 = double __attribute__((vector_size(32)));
using IntX4 = std::int32_t __attribute__((vector_size(16)));

inline FloatX4 broadcast_x4(float x) { return FloatX4{x, x, x, x}; }
inline FloatX4 load_x4(const float* p) {
  FloatX4 x;
  std::memcpy(&x, p, sizeof x);
  return x;
}

/// Loads two floats; lanes 2 and 3 are zero.
inline FloatX4 load_x2(const float* p) {
  double both;
  std::memcpy(&both, p, sizeof both);
  return FloatX4(DoubleX2{both, 0.0});
}

[[gnu::always_inline]] inline FloatX4 min(FloatX4 x, FloatX4 y) { return x < y ? x : y; }
[[gnu::always_inline]] inline FloatX4 max(FloatX4 x, FloatX4 y) { return x > y ? x : y; }

/// Transposes a 4 × 4 matrix.
[[gnu::always_inline]] inline void transpose(const FloatX4 (&rows)[4], FloatX4 (&columns)[4]) {
  const FloatX4 low[2] = {__builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5),
                          __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5)};
  const FloatX4 high[2] = {__builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7),
                           __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7)};
  columns[0] = __builtin_shufflevector(low[0], low[1], 0, 1, 4, 5);
  columns[1] = __builtin_shufflevector(low[0], low[1], 2, 3, 6, 7);
  columns[2] = __builtin_shufflevector(high[0], high[1], 0, 1, 4, 5);
  columns[3] = __builtin_shufflevector(high[0], high[1], 2, 3, 6, 7);
}

/// May round once or twice: for culling only.
[[gnu::always_inline]] inline FloatX4 fma(FloatX4 x, FloatX4 y, FloatX4 z) {
#if defined(__FMA__)
  return FloatX4(_mm_fmadd_ps(__m128(x), __m128(y), __m128(z)));
#else
  return x * y + z;
#endif
}

/// Converts four floats to double.
[[gnu::always_inline]] inline void to_double(const FloatX4& x, DoubleX4& wide) {
#if defined(__AVX__)
  wide = DoubleX4(_mm256_cvtps_pd(__m128(x)));  // one instruction; __builtin_convertvector takes six
#else
  wide = __builtin_convertvector(x, DoubleX4);
#endif
}

}  // namespace fastlines
