// Eight lanes of float32 in the compiler's vector types.
//
// Every operation gives the same bits on every instruction set. Only inline functions pass these vectors by value, so
// GCC's warning about their ABI (-Wpsabi) is moot. It stays disabled, because GCC instantiates templates at the end of
// the file.
#pragma once

#include <bit>
#include <cstdint>

#include "float_x4.hpp"

#if defined(FASTLINES_PORTABLE)
#elif defined(__SSE4_2__)
#include <immintrin.h>
#endif

#pragma GCC diagnostic ignored "-Wpsabi"

namespace fastlines {

using FloatX8 = float __attribute__((vector_size(32)));
using IntX8 = std::int32_t __attribute__((vector_size(32)));

[[gnu::always_inline]] inline FloatX8 broadcast_x8(float x) { return FloatX8{} + x; }
[[gnu::always_inline]] inline FloatX8 min(const FloatX8& x, const FloatX8& y) { return x < y ? x : y; }
[[gnu::always_inline]] inline FloatX8 max(const FloatX8& x, const FloatX8& y) { return x > y ? x : y; }

/// Concatenates two vectors of four.
[[gnu::always_inline]] inline FloatX8 concatenate(const FloatX4& low, const FloatX4& high) {
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// A bit for each lane of a mask that is set.
[[gnu::always_inline]] inline unsigned bits_of(const IntX8& mask) {
#if !defined(FASTLINES_PORTABLE) && defined(__AVX__)
  return unsigned(_mm256_movemask_ps(__m256(mask)));
#elif !defined(FASTLINES_PORTABLE) && defined(__SSE4_2__)
  __m128 half[2];
  __builtin_memcpy(half, &mask, sizeof half);
  return unsigned(_mm_movemask_ps(half[0]) | _mm_movemask_ps(half[1]) << 4);
#else
  unsigned bits = 0;
  for (int lane = 0; lane < 8; ++lane) bits |= unsigned(mask[lane]) & 1u << lane;
  return bits;
#endif
}

/// The number of set lanes.
[[gnu::always_inline]] inline unsigned count_set(const IntX8& mask) { return unsigned(std::popcount(bits_of(mask))); }

/// The minimum over all lanes, in all lanes.
[[gnu::always_inline]] inline FloatX8 broadcast_min(const FloatX8& x) {
  FloatX8 least = min(x, FloatX8(__builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3)));
  least = min(least, FloatX8(__builtin_shufflevector(least, least, 2, 3, 0, 1, 6, 7, 4, 5)));
  return min(least, FloatX8(__builtin_shufflevector(least, least, 1, 0, 3, 2, 5, 4, 7, 6)));
}

/// The minimum over all lanes.
[[gnu::always_inline]] inline float reduce_min(const FloatX8& x) { return broadcast_min(x)[0]; }

/// The lowest lane that holds the minimum.
[[gnu::always_inline]] inline unsigned index_of_min(const FloatX8& x) {
  return unsigned(std::countr_zero(bits_of(x == broadcast_min(x))));
}

/// Transposes eight points to their x, y and z; lane 3 of each is dropped.
[[gnu::always_inline]] inline void transpose(const FloatX4 (&fours)[8], FloatX8 (&eights)[3]) {
  const FloatX8 a = concatenate(fours[0], fours[4]), b = concatenate(fours[1], fours[5]),
                c = concatenate(fours[2], fours[6]), d = concatenate(fours[3], fours[7]);
  const FloatX8 ab = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13),
                cd = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  eights[0] = __builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13);
  eights[1] = __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15);
  const FloatX8 ab_last = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15),
                cd_last = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  eights[2] = __builtin_shufflevector(ab_last, cd_last, 0, 1, 8, 9, 4, 5, 12, 13);
}

}  // namespace fastlines
