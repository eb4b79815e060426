// Registers of 16-bit and 32-bit integers, one source for AVX2 and SSE4.2. FASTLINES_INT16 says that they exist and
// that leaves are culled with them. AVX-512 is faster with dot products of bytes (leaf_cull.hpp).
#pragma once

#include <cstdint>
#include <cstring>

#include "float_x16.hpp"

#if !defined(FASTLINES_PORTABLE) && !defined(__AVX512F__) && defined(__SSE4_2__)
#define FASTLINES_INT16

#include <immintrin.h>

// The intrinsic of an operation for this width; only this file uses it.
#if defined(__AVX2__)
#define FASTLINES_MM(operation) _mm256_##operation
#else
#define FASTLINES_MM(operation) _mm_##operation
#endif

namespace fastlines {

#if defined(__AVX2__)
using Register = __m256i;
using FloatRegister = __m256;
#else
using Register = __m128i;
using FloatRegister = __m128;
#endif

/// A mask of 32-bit lanes; only the sign of a lane counts.
struct Mask32s {
  Register v;
  friend Mask32s operator|(Mask32s x, Mask32s y) { return {x.v | y.v}; }
  friend Mask32s operator&(Mask32s x, Mask32s y) { return {x.v & y.v}; }
};

/// A register of 32-bit integers.
struct Int32s {
  Register v;

  /// x truncated to an integer, in all lanes.
  static Int32s of(float x) { return {FASTLINES_MM(cvttps_epi32)(FASTLINES_MM(set1_ps)(x))}; }
  FloatRegister floats() const { return FASTLINES_MM(cvtepi32_ps)(v); }
  friend Int32s operator-(Int32s x, Int32s y) { return {FASTLINES_MM(sub_epi32)(x.v, y.v)}; }
  friend Mask32s operator<(Int32s x, Int32s y) { return {FASTLINES_MM(cmpgt_epi32)(y.v, x.v)}; }
};
inline Int32s min(Int32s x, Int32s y) { return {FASTLINES_MM(min_epi32)(x.v, y.v)}; }
inline Int32s abs(Int32s x) { return {FASTLINES_MM(abs_epi32)(x.v)}; }

/// The lanes where x² < y·z, evaluated in float32.
inline Mask32s is_square_within(Int32s x, Int32s y, float z) {
  const FloatRegister a = x.floats(), b = FASTLINES_MM(mul_ps)(y.floats(), FASTLINES_MM(set1_ps)(z));
#if defined(__FMA__)
  const FloatRegister excess = FASTLINES_MM(fmsub_ps)(a, a, b);
#else
  const FloatRegister excess = FASTLINES_MM(sub_ps)(FASTLINES_MM(mul_ps)(a, a), b);
#endif
  Register signs;
  std::memcpy(&signs, &excess, sizeof signs);
  return {signs};
}

/// A register of 16-bit integers.
struct Int16s {
  static constexpr int kCount = sizeof(Register) / 2;
  Register v;

  static Int16s all(std::int16_t x) { return {FASTLINES_MM(set1_epi16)(x)}; }
  /// Loads a whole register: 16 or 32 bytes.
  static Int16s load(const std::uint8_t* bytes) {
    Int16s words;
    std::memcpy(&words.v, bytes, sizeof words.v);
    return words;
  }
  /// The sums of two neighbouring products of the unsigned bytes of x and the signed bytes of y, with saturation.
  friend Int16s dot_bytes(Int16s x, Int16s y) { return {FASTLINES_MM(maddubs_epi16)(x.v, y.v)}; }
  friend Int16s operator+(Int16s x, Int16s y) { return {FASTLINES_MM(add_epi16)(x.v, y.v)}; }
  friend Int16s operator<<(Int16s x, int n_bits) { return {FASTLINES_MM(slli_epi16)(x.v, n_bits)}; }
  friend Int16s operator-(Int16s x, Int16s y) { return {FASTLINES_MM(sub_epi16)(x.v, y.v)}; }
  friend Int16s add_saturated(Int16s x, Int16s y) { return {FASTLINES_MM(adds_epi16)(x.v, y.v)}; }
};

/// Pairs (x, y) of 16-bit integers, for the low or the high half of the lanes of x and y.
struct Int16Pairs {
  Register v;

  template <bool low>
  static Int16Pairs of(Int16s x, Int16s y) {
    return {low ? FASTLINES_MM(unpacklo_epi16)(x.v, y.v) : FASTLINES_MM(unpackhi_epi16)(x.v, y.v)};
  }
  friend Int32s dot(Int16Pairs x, Int16Pairs y) { return {FASTLINES_MM(madd_epi16)(x.v, y.v)}; }
};

/// Packs two masks of 32-bit lanes into one register of 16-bit lanes.
inline Int16s join(Mask32s low, Mask32s high) { return {FASTLINES_MM(packs_epi32)(low.v, high.v)}; }

/// A bit for the sign of each of 16 lanes of 16 bits.
#if defined(__AVX2__)
inline std::uint32_t bits_of(const Int16s (&x)[1]) {
  return std::uint32_t(
      _mm_movemask_epi8(_mm_packs_epi16(_mm256_castsi256_si128(x[0].v), _mm256_extracti128_si256(x[0].v, 1))));
}
#else
inline std::uint32_t bits_of(const Int16s (&x)[2]) {
  return std::uint32_t(_mm_movemask_epi8(_mm_packs_epi16(x[0].v, x[1].v)));
}
#endif

}  // namespace fastlines

#undef FASTLINES_MM
#endif
