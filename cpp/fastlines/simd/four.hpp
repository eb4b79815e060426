// Four lanes: a point, with one lane to spare, in float and in double. The compiler's own vectors will do here.
//
// As in simd.hpp, every operation gives the same bits on every instruction set.
#pragma once

#include <cstring>

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace fastlines {

using Float4 = float __attribute__((vector_size(16)));
using Double2 = double __attribute__((vector_size(16)));
using Double4 = double __attribute__((vector_size(32)));
using Int4 = int __attribute__((vector_size(16)));

inline Float4 four(float x) { return Float4{x, x, x, x}; }
inline Float4 four(const float* p) {
  Float4 x;
  std::memcpy(&x, p, sizeof x);
  return x;
}

/// Two numbers, and two zeros.
inline Float4 two(const float* p) {
  double both;
  std::memcpy(&both, p, sizeof both);
  return Float4(Double2{both, 0.0});
}

[[gnu::always_inline]] inline Float4 min(Float4 x, Float4 y) { return x < y ? x : y; }
[[gnu::always_inline]] inline Float4 max(Float4 x, Float4 y) { return x > y ? x : y; }

/// What is first in four vectors of four, what is second, and so on.
[[gnu::always_inline]] inline void turn(const Float4 (&rows)[4], Float4 (&columns)[4]) {
  const Float4 low[2] = {__builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5),
                         __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5)};
  const Float4 high[2] = {__builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7),
                          __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7)};
  columns[0] = __builtin_shufflevector(low[0], low[1], 0, 1, 4, 5);
  columns[1] = __builtin_shufflevector(low[0], low[1], 2, 3, 6, 7);
  columns[2] = __builtin_shufflevector(high[0], high[1], 0, 1, 4, 5);
  columns[3] = __builtin_shufflevector(high[0], high[1], 2, 3, 6, 7);
}

/// Rounds once or twice: for culling only.
[[gnu::always_inline]] inline Float4 fma(Float4 x, Float4 y, Float4 z) {
#if defined(__FMA__)
  return Float4(_mm_fmadd_ps(__m128(x), __m128(y), __m128(z)));
#else
  return x * y + z;
#endif
}

[[gnu::always_inline]] inline void to_double(const Float4& x, Double4& wide) {
#if defined(__AVX__)
  wide = Double4(_mm256_cvtps_pd(__m128(x)));  // the compiler would take six instructions
#else
  wide = __builtin_convertvector(x, Double4);
#endif
}

}  // namespace fastlines
