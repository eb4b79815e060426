// Vectors of W lanes for the loops of peers, which are compiled once for each instruction set. For W = 1, a scalar.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#endif

// A namespace without linkage: every file has functions of its own instruction set.
namespace {

template <int W>
struct Lanes {
  typedef float F __attribute__((vector_size(4 * W)));
  typedef std::int32_t I __attribute__((vector_size(4 * W)));
};
template <>
struct Lanes<1> {
  using F = float;
  using I = std::int32_t;
};

template <class Value>
Value load(const void* from) {
  Value value;
  std::memcpy(&value, from, sizeof(Value));
  return value;
}

inline unsigned bits(std::int32_t mask) { return mask != 0; }

template <class I>
unsigned bits(const I& mask) {
#ifdef __AVX512DQ__
  if constexpr (sizeof(I) == 64) return _mm512_movepi32_mask((__m512i)mask);
#endif
#ifdef __AVX2__
  if constexpr (sizeof(I) == 32) return unsigned(_mm256_movemask_ps((__m256)mask));
  if constexpr (sizeof(I) == 16) return unsigned(_mm_movemask_ps((__m128)mask));
#endif
  unsigned found = 0;
  for (unsigned i = 0; i < sizeof(I) / 4; ++i) found |= unsigned(mask[i] != 0) << i;
  return found;
}

/// A comparison as a mask with lanes of −1 and 0; a scalar comparison gives a bool.
template <class I, class Compared>
I as_mask(const Compared& compared) {
  if constexpr (std::is_same_v<Compared, bool>)
    return -I(compared);
  else
    return (I)compared;
}

template <class I, class F>
F blend(const I& mask, const F& yes, const F& no) {
  return mask ? yes : no;
}

template <class I, class F>
F clamp01(const F& x) {
  const F zero{}, one = zero + 1.0f;
  const F low = blend(as_mask<I>(x > zero), x, zero);
  return blend(as_mask<I>(low < one), low, one);
}

template <class F>
F square_root(const F& x) {
  if constexpr (std::is_same_v<F, float>) {
    return std::sqrt(x);
  } else {
#ifdef __AVX512F__
    if constexpr (sizeof(F) == 64)
      return (F)_mm512_maskz_sqrt_ps(0xffff, (__m512)x);  // _mm512_sqrt_ps warns (GCC bug 105593)
#endif
#ifdef __AVX2__
    if constexpr (sizeof(F) == 32) return (F)_mm256_sqrt_ps((__m256)x);
    if constexpr (sizeof(F) == 16) return (F)_mm_sqrt_ps((__m128)x);
#endif
    F root;
    for (unsigned i = 0; i < sizeof(F) / 4; ++i) root[i] = std::sqrt(x[i]);
    return root;
  }
}

/// exp(x) for x ≤ 0, within 2⁻²²: 2ᵏ times the series of the rest, which is at most ln(2)/2.
template <class I, class F>
F exponential(const F& exponent) {
  const F least = F{} - 87.0f, shift = F{} + 12582912.0f;  // 1.5·2²³: a sum with it is rounded to a whole number
  const F x = blend(as_mask<I>(exponent > least), exponent, least);
  const F shifted = x * 1.44269504f + shift, k = shifted - shift;
  const F r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  F series = F{} + 1.0f / 720;
  for (const float term : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f, 1.0f}) series = series * r + term;
  const I power = (__builtin_bit_cast(I, shifted) - __builtin_bit_cast(I, shift) + 127) << 23;
  return series * __builtin_bit_cast(F, power);
}

}  // namespace
