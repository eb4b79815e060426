// FloatX16 for AVX2: 16 lanes of float32 in two registers.
#pragma once

#include <immintrin.h>

#include <bit>
#include <cstdint>

#include "compress.hpp"
#include "float_x4.hpp"

namespace fastlines {

inline constexpr const char* kSimd = "avx2";

struct MaskX16 {
  __m256 a, b;
  std::uint32_t bits() const {
    return std::uint32_t(_mm256_movemask_ps(a)) | std::uint32_t(_mm256_movemask_ps(b)) << 8;
  }
  friend MaskX16 operator&(MaskX16 x, MaskX16 y) { return {_mm256_and_ps(x.a, y.a), _mm256_and_ps(x.b, y.b)}; }
  friend MaskX16 operator|(MaskX16 x, MaskX16 y) { return {_mm256_or_ps(x.a, y.a), _mm256_or_ps(x.b, y.b)}; }
};

struct FloatX16 {
  __m256 a, b;
  static constexpr int kRegisters = 2;
  static constexpr int kMaxPermuteTable = 16;  // the most floats in a table for which permute is fast

  FloatX16() = default;
  FloatX16(__m256 a_, __m256 b_) : a(a_), b(b_) {}
  FloatX16(float x) : a(_mm256_set1_ps(x)), b(a) {}

  static FloatX16 load(const float* p) { return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)}; }
  /// 16 bytes, converted to float.
  static FloatX16 bytes(const std::uint8_t* p) {
    const auto eight = [](const std::uint8_t* from) {
      return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
    };
    return {eight(p), eight(p + 8)};
  }
  /// Lane k of x, broadcast to all lanes.
  template <int k>
  static FloatX16 broadcast(const FloatX4& x) {
    const __m256 twice = _mm256_insertf128_ps(_mm256_castps128_ps256(__m128(x)), __m128(x), 1);  // shared by all k
    const __m256 all = _mm256_permute_ps(twice, k * 0x55);
    return {all, all};
  }
  /// Four floats of each of four rows, one row per group of four lanes; store_rows is the inverse.
  static FloatX16 of_rows(const float* p, const float* q, const float* r, const float* s) {
    return {_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p)), _mm_loadu_ps(q), 1),
            _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(r)), _mm_loadu_ps(s), 1)};
  }
  void store_rows(float* p, float* q, float* r, float* s) const {
    _mm_storeu_ps(p, _mm256_castps256_ps128(a));
    _mm_storeu_ps(q, _mm256_extractf128_ps(a, 1));
    _mm_storeu_ps(r, _mm256_castps256_ps128(b));
    _mm_storeu_ps(s, _mm256_extractf128_ps(b, 1));
  }
  /// In each group of four lanes: lanes i and j of x, then lanes k and l of y.
  template <int i, int j, int k, int l>
  static FloatX16 shuffle(FloatX16 x, FloatX16 y) {
    constexpr int order = _MM_SHUFFLE(l, k, j, i);
    return {_mm256_shuffle_ps(x.a, y.a, order), _mm256_shuffle_ps(x.b, y.b, order)};
  }
  void store(float* p) const {
    _mm256_storeu_ps(p, a);
    _mm256_storeu_ps(p + 8, b);
  }
  /// table[index[i] % 16] in each lane i.
  template <int n = 16>
    requires(n == 16)
  static FloatX16 permute(const float* table, const std::uint32_t* index) {
    const __m256 low = _mm256_loadu_ps(table), high = _mm256_loadu_ps(table + 8);
    const auto eight = [&](const std::uint32_t* from) {
      const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
      return _mm256_blendv_ps(_mm256_permutevar8x32_ps(low, at), _mm256_permutevar8x32_ps(high, at),
                              _mm256_castsi256_ps(_mm256_slli_epi32(at, 28)));
    };
    return {eight(index), eight(index + 8)};
  }

  /// Writes table[index[i] % 16] for a table of 16 doubles.
  static void permute(const double* table, const std::uint32_t* index, double* to) {
    for (int i = 0; i < 16; ++i) to[i] = table[index[i] % 16];
  }

  friend FloatX16 operator+(FloatX16 x, FloatX16 y) { return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)}; }
  friend FloatX16 operator-(FloatX16 x, FloatX16 y) { return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)}; }
  friend FloatX16 operator*(FloatX16 x, FloatX16 y) { return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)}; }
  friend FloatX16 operator/(FloatX16 x, FloatX16 y) { return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)}; }
  friend MaskX16 operator<=(FloatX16 x, FloatX16 y) {
    return {_mm256_cmp_ps(x.a, y.a, _CMP_LE_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LE_OQ)};
  }
  friend MaskX16 operator<(FloatX16 x, FloatX16 y) {
    return {_mm256_cmp_ps(x.a, y.a, _CMP_LT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LT_OQ)};
  }
};

inline FloatX16 min(FloatX16 x, FloatX16 y) { return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)}; }
inline FloatX16 max(FloatX16 x, FloatX16 y) { return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)}; }
inline FloatX16 fma(FloatX16 x, FloatX16 y, FloatX16 z) {
  return {_mm256_fmadd_ps(x.a, y.a, z.a), _mm256_fmadd_ps(x.b, y.b, z.b)};
}
inline FloatX16 fnma(FloatX16 x, FloatX16 y, FloatX16 z) {
  return {_mm256_fnmadd_ps(x.a, y.a, z.a), _mm256_fnmadd_ps(x.b, y.b, z.b)};
}
inline FloatX16 blend(MaskX16 mask, FloatX16 x, FloatX16 y) {
  return {_mm256_blendv_ps(y.a, x.a, mask.a), _mm256_blendv_ps(y.b, x.b, mask.b)};
}

/// x in the lanes whose bit is set, y in the others.
inline FloatX16 blend(std::uint32_t bits, FloatX16 x, FloatX16 y) {
  const __m256i all = _mm256_set1_epi32(int(bits));
  const auto sign = [all](int a, int b, int c, int d, int e, int f, int g, int h) {
    return _mm256_castsi256_ps(_mm256_sllv_epi32(all, _mm256_setr_epi32(a, b, c, d, e, f, g, h)));
  };
  return {_mm256_blendv_ps(y.a, x.a, sign(31, 30, 29, 28, 27, 26, 25, 24)),
          _mm256_blendv_ps(y.b, x.b, sign(23, 22, 21, 20, 19, 18, 17, 16))};
}

/// The permutation that moves the set lanes of an 8-bit mask to the front.
inline __m256i compress_permutation(std::uint32_t byte) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompressTable.lanes[byte])));
}

/// Moves the lanes whose bit is set to the front. Writes 16 floats; those past the set lanes have any value.
inline void compress(std::uint32_t bits, FloatX16 x, float* to) {
  _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(x.a, compress_permutation(bits & 0xff)));
  _mm256_storeu_ps(to + std::popcount(bits & 0xff), _mm256_permutevar8x32_ps(x.b, compress_permutation(bits >> 8)));
}

/// base + i for each set bit i, in order. Writes 16 integers; those past the set bits have any value.
inline void compress_indices(std::uint32_t bits, std::uint32_t base, std::uint32_t* to) {
  const auto store = [](std::uint32_t* at, __m256i x) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(at), x); };
  const __m256i low = _mm256_set1_epi32(int(base)), high = _mm256_add_epi32(low, _mm256_set1_epi32(8));
  store(to, _mm256_add_epi32(compress_permutation(bits & 0xff), low));
  store(to + std::popcount(bits & 0xff), _mm256_add_epi32(compress_permutation(bits >> 8), high));
}

/// A bit for each of 16 integers that is not zero.
inline std::uint32_t nonzero_mask(const std::uint32_t* numbers) {
  const auto eight = [](const std::uint32_t* from) {
    const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    return std::uint32_t(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(all, _mm256_setzero_si256()))));
  };
  return ~(eight(numbers) | eight(numbers + 8) << 8) & 0xffff;
}

/// A bit for each lane where the sign bits of both x and y are 0, or that of z, or that of w.
inline std::uint32_t nonnegative_mask(FloatX16 x, FloatX16 y, FloatX16 z, FloatX16 w) {
  const auto eight = [](__m256 a, __m256 b, __m256 c, __m256 d) {
    return std::uint32_t(_mm256_movemask_ps(_mm256_and_ps(_mm256_and_ps(_mm256_or_ps(a, b), c), d)));
  };
  return ~(eight(x.a, y.a, z.a, w.a) | eight(x.b, y.b, z.b, w.b) << 8) & 0xffff;
}

/// The minimum over all lanes.
inline float reduce_min(FloatX16 x) {
  const __m256 eight = _mm256_min_ps(x.a, x.b);
  __m128 four = _mm_min_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  four = _mm_min_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_min_ss(four, _mm_movehdup_ps(four)));
}

/// The lane of the least number among those whose bit is set, at least one, and a lower bound of that number. The lane
/// takes the place of the last four bits, so that one minimum of integers finds both; the other bits decide.
inline std::uint32_t least_lane(std::uint32_t bits, FloatX16 x, float& at_least) {
  const auto keys = [](__m256 eight, int first) {
    const __m256i number = _mm256_castps_si256(eight), largest = _mm256_set1_epi32(INT32_MAX);
    const __m256i ordered = _mm256_xor_si256(number, _mm256_and_si256(_mm256_srai_epi32(number, 31), largest));
    const __m256i lanes = _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_epi32(first));
    return _mm256_castsi256_ps(_mm256_or_si256(_mm256_andnot_si256(_mm256_set1_epi32(15), ordered), lanes));
  };
  const __m256 largest = _mm256_castsi256_ps(_mm256_set1_epi32(INT32_MAX));
  const FloatX16 some = blend(bits, FloatX16(keys(x.a, 0), keys(x.b, 8)), FloatX16(largest, largest));
  const __m256i eight = _mm256_min_epi32(_mm256_castps_si256(some.a), _mm256_castps_si256(some.b));
  __m128i four = _mm_min_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
  four = _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
  four = _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(2, 3, 0, 1)));
  const std::int32_t least = _mm_cvtsi128_si32(four), rounded = least & ~15;
  at_least = std::bit_cast<float>(rounded ^ (rounded >> 31 & INT32_MAX));
  return std::uint32_t(least & 15);
}

inline FloatX16 sqrt(FloatX16 x) { return {_mm256_sqrt_ps(x.a), _mm256_sqrt_ps(x.b)}; }
inline FloatX16 abs(FloatX16 x) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, x.a), _mm256_andnot_ps(sign, x.b)};
}

}  // namespace fastlines
