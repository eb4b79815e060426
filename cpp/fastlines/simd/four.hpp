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

[[gnu::always_inline]] inline Float4 min(Float4 x, Float4 y) { return x < y ? x : y; }
[[gnu::always_inline]] inline Float4 max(Float4 x, Float4 y) { return x > y ? x : y; }

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
