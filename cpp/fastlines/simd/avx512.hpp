// FloatX16 for AVX-512: 16 lanes of float32 in one register.
#pragma once

#include <immintrin.h>

#include <bit>
#include <cstdint>

#include "float_x4.hpp"

namespace fastlines {

inline constexpr const char* kSimd = "avx512";

struct MaskX16 {
  __mmask16 m;
  std::uint32_t bits() const { return m; }
  friend MaskX16 operator&(MaskX16 x, MaskX16 y) { return {__mmask16(x.m & y.m)}; }
  friend MaskX16 operator|(MaskX16 x, MaskX16 y) { return {__mmask16(x.m | y.m)}; }
};

struct FloatX16 {
  __m512 a;
  static constexpr int kRegisters = 1;
  static constexpr int kMaxPermuteTable = 64;  // the most floats in a table for which permute is fast

  FloatX16() = default;
  FloatX16(__m512 a_) : a(a_) {}
  FloatX16(float x) : a(_mm512_set1_ps(x)) {}

  static FloatX16 load(const float* p) { return _mm512_loadu_ps(p); }
  /// 16 bytes, converted to float.
  static FloatX16 bytes(const std::uint8_t* p) {
    return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
  }
  /// Lane k of x, broadcast to all lanes.
  template <int k>
  static FloatX16 broadcast(const FloatX4& x) {
    return _mm512_permutexvar_ps(_mm512_set1_epi32(k), _mm512_castps128_ps512(__m128(x)));
  }
  /// Four floats of each of four rows, one row per group of four lanes; store_rows is the inverse.
  static FloatX16 of_rows(const float* p, const float* q, const float* r, const float* s) {
    __m512 x = _mm512_castps128_ps512(_mm_loadu_ps(p));
    x = _mm512_insertf32x4(x, _mm_loadu_ps(q), 1);
    x = _mm512_insertf32x4(x, _mm_loadu_ps(r), 2);
    return _mm512_insertf32x4(x, _mm_loadu_ps(s), 3);
  }
  void store_rows(float* p, float* q, float* r, float* s) const {
    _mm_storeu_ps(p, _mm512_castps512_ps128(a));
    _mm_storeu_ps(q, _mm512_extractf32x4_ps(a, 1));
    _mm_storeu_ps(r, _mm512_extractf32x4_ps(a, 2));
    _mm_storeu_ps(s, _mm512_extractf32x4_ps(a, 3));
  }
  /// In each group of four lanes: lanes i and j of x, then lanes k and l of y.
  template <int i, int j, int k, int l>
  static FloatX16 shuffle(FloatX16 x, FloatX16 y) {
    return _mm512_shuffle_ps(x.a, y.a, _MM_SHUFFLE(l, k, j, i));
  }
  void store(float* p) const { _mm512_storeu_ps(p, a); }
  /// table[index[i] % n] in each lane i, for a table of n = 16 or 64 floats.
  template <int n = 16>
    requires(n == 16 || n == 64)
  static FloatX16 permute(const float* table, const std::uint32_t* index) {
    const __m512i at = _mm512_loadu_si512(index);
    if constexpr (n == 16) {
      return _mm512_permutexvar_ps(at, _mm512_loadu_ps(table));
    } else {
      const auto of_32 = [at](const float* from) {
        return _mm512_permutex2var_ps(_mm512_loadu_ps(from), at, _mm512_loadu_ps(from + 16));
      };
      const __mmask16 is_high = _mm512_test_epi32_mask(at, _mm512_set1_epi32(32));
      return _mm512_mask_blend_ps(is_high, of_32(table), of_32(table + 32));
    }
  }

  /// Writes table[index[i] % 16] for a table of 16 doubles.
  static void permute(const double* table, const std::uint32_t* index, double* to) {
    const __m512d low = _mm512_loadu_pd(table), high = _mm512_loadu_pd(table + 8);
    for (int i = 0; i < 16; i += 8) {
      const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index + i));
      _mm512_storeu_pd(to + i, _mm512_permutex2var_pd(low, _mm512_cvtepu32_epi64(at), high));
    }
  }

  friend FloatX16 operator+(FloatX16 x, FloatX16 y) { return _mm512_add_ps(x.a, y.a); }
  friend FloatX16 operator-(FloatX16 x, FloatX16 y) { return _mm512_sub_ps(x.a, y.a); }
  friend FloatX16 operator*(FloatX16 x, FloatX16 y) { return _mm512_mul_ps(x.a, y.a); }
  friend FloatX16 operator/(FloatX16 x, FloatX16 y) { return _mm512_div_ps(x.a, y.a); }
  friend MaskX16 operator<=(FloatX16 x, FloatX16 y) { return {_mm512_cmp_ps_mask(x.a, y.a, _CMP_LE_OQ)}; }
  friend MaskX16 operator<(FloatX16 x, FloatX16 y) { return {_mm512_cmp_ps_mask(x.a, y.a, _CMP_LT_OQ)}; }
};

inline FloatX16 min(FloatX16 x, FloatX16 y) { return _mm512_min_ps(x.a, y.a); }
inline FloatX16 max(FloatX16 x, FloatX16 y) { return _mm512_max_ps(x.a, y.a); }
inline FloatX16 fma(FloatX16 x, FloatX16 y, FloatX16 z) { return _mm512_fmadd_ps(x.a, y.a, z.a); }
inline FloatX16 fnma(FloatX16 x, FloatX16 y, FloatX16 z) { return _mm512_fnmadd_ps(x.a, y.a, z.a); }
inline FloatX16 blend(MaskX16 mask, FloatX16 x, FloatX16 y) { return _mm512_mask_blend_ps(mask.m, y.a, x.a); }

/// x in the lanes whose bit is set, y in the others.
inline FloatX16 blend(std::uint32_t bits, FloatX16 x, FloatX16 y) {
  return _mm512_mask_blend_ps(__mmask16(bits), y.a, x.a);
}

/// Moves the lanes whose bit is set to the front. Writes 16 floats; those past the set lanes have any value.
inline void compress(std::uint32_t bits, FloatX16 x, float* to) {
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(__mmask16(bits), x.a));
}

/// base + i for each set bit i, in order. Writes 16 integers; those past the set bits have any value.
inline void compress_indices(std::uint32_t bits, std::uint32_t base, std::uint32_t* to) {
  const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i numbers = _mm512_add_epi32(lanes, _mm512_set1_epi32(int(base)));
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(__mmask16(bits), numbers));
}

/// A bit for each of 16 integers that is not zero.
inline std::uint32_t nonzero_mask(const std::uint32_t* numbers) {
  const __m512i all = _mm512_loadu_si512(numbers);
  return _mm512_test_epi32_mask(all, all);
}

/// A bit for each lane where the sign bits of both x and y are 0, or that of z, or that of w.
inline std::uint32_t nonnegative_mask(FloatX16 x, FloatX16 y, FloatX16 z, FloatX16 w) {
  const auto bits = [](FloatX16 of) { return _mm512_castps_si512(of.a); };
  constexpr int or_and = 0xa8;  // (x | y) & z
  const __m512i xyz = _mm512_ternarylogic_epi32(bits(x), bits(y), bits(z), or_and);
  return _mm512_testn_epi32_mask(_mm512_and_si512(xyz, bits(w)), _mm512_set1_epi32(INT32_MIN));
}

/// The minimum over all lanes.
inline float reduce_min(FloatX16 x) { return _mm512_reduce_min_ps(x.a); }

/// The lane of the least number among those whose bit is set, at least one, and a lower bound of that number. The lane
/// takes the place of the last four bits, so that one minimum of integers finds both; the other bits decide.
inline std::uint32_t least_lane(std::uint32_t bits, FloatX16 x, float& at_least) {
  const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i number = _mm512_castps_si512(x.a), sign = _mm512_srai_epi32(number, 31);
  constexpr int xor_and = 0x78, choose = 0xca;  // x ^ (y & z); x ? y : z
  const __m512i ordered = _mm512_ternarylogic_epi32(number, sign, _mm512_set1_epi32(INT32_MAX), xor_and);
  const __m512i keys = _mm512_ternarylogic_epi32(_mm512_set1_epi32(15), lanes, ordered, choose);
  const std::int32_t least = _mm512_mask_reduce_min_epi32(__mmask16(bits), keys), rounded = least & ~15;
  at_least = std::bit_cast<float>(rounded ^ (rounded >> 31 & INT32_MAX));
  return std::uint32_t(least & 15);
}

inline FloatX16 sqrt(FloatX16 x) { return _mm512_sqrt_ps(x.a); }
inline FloatX16 abs(FloatX16 x) { return _mm512_abs_ps(x.a); }

}  // namespace fastlines
