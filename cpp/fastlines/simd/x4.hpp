// FloatX16 for SSE4.2, NEON and portable code: four vectors of four lanes, in the compiler's vector types.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "compress.hpp"
#include "float_x4.hpp"

#if defined(FASTLINES_PORTABLE)
#elif defined(__SSE4_2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

namespace fastlines {

#if defined(FASTLINES_PORTABLE)
inline constexpr const char* kSimd = "portable";
#elif defined(__SSE4_2__)
inline constexpr const char* kSimd = "sse42";
#elif defined(__ARM_NEON)
inline constexpr const char* kSimd = "neon";
#else
inline constexpr const char* kSimd = "portable";
#endif

/// A bit for each lane of a mask that is set.
inline std::uint32_t bits_of(IntX4 mask) {
#if defined(__SSE4_2__) && !defined(FASTLINES_PORTABLE)
  return std::uint32_t(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#elif defined(__ARM_NEON) && !defined(FASTLINES_PORTABLE)
  const uint32x4_t weights = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(reinterpret_cast<uint32x4_t>(mask), weights));
#else
  return std::uint32_t((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

/// Four bytes, converted to float.
inline FloatX4 x4_of_bytes(const std::uint8_t* p) {
#if defined(__SSE4_2__) && !defined(FASTLINES_PORTABLE)
  std::int32_t four;
  std::memcpy(&four, p, 4);
  return _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(four)));
#elif defined(__ARM_NEON) && !defined(FASTLINES_PORTABLE)
  std::uint32_t four;
  std::memcpy(&four, p, 4);
  return vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(vcreate_u8(four)))));
#else
  return FloatX4{float(p[0]), float(p[1]), float(p[2]), float(p[3])};
#endif
}

struct MaskX16 {
  IntX4 v[4];
  std::uint32_t bits() const { return bits_of(v[0]) | bits_of(v[1]) << 4 | bits_of(v[2]) << 8 | bits_of(v[3]) << 12; }
  friend MaskX16 operator&(MaskX16 x, MaskX16 y) {
    return {x.v[0] & y.v[0], x.v[1] & y.v[1], x.v[2] & y.v[2], x.v[3] & y.v[3]};
  }
  friend MaskX16 operator|(MaskX16 x, MaskX16 y) {
    return {x.v[0] | y.v[0], x.v[1] | y.v[1], x.v[2] | y.v[2], x.v[3] | y.v[3]};
  }
};

struct FloatX16 {
  FloatX4 v[4];
  static constexpr int kRegisters = 4;
#if defined(FASTLINES_COUNTERS)
  static constexpr int kMaxPermuteTable = 64;  // as for AVX-512, so that its steps are counted
#else
  static constexpr int kMaxPermuteTable = 0;  // permute is slower for any table
#endif

  FloatX16() = default;
  FloatX16(FloatX4 a, FloatX4 b, FloatX4 c, FloatX4 d) : v{a, b, c, d} {}
  FloatX16(float x) : v{FloatX4{x, x, x, x}, FloatX4{x, x, x, x}, FloatX4{x, x, x, x}, FloatX4{x, x, x, x}} {}

  static FloatX16 load(const float* p) {
    FloatX16 x;
    std::memcpy(x.v, p, sizeof x.v);
    return x;
  }
  /// 16 bytes, converted to float.
  static FloatX16 bytes(const std::uint8_t* p) {
    return {x4_of_bytes(p), x4_of_bytes(p + 4), x4_of_bytes(p + 8), x4_of_bytes(p + 12)};
  }
  /// Lane k of x, broadcast to all lanes.
  template <int k>
  static FloatX16 broadcast(const FloatX4& x) {
    return {x[k]};
  }
  /// Four floats of each of four rows, one row per group of four lanes; store_rows is the inverse.
  static FloatX16 of_rows(const float* p, const float* q, const float* r, const float* s) {
    return {load_x4(p), load_x4(q), load_x4(r), load_x4(s)};
  }
  void store_rows(float* p, float* q, float* r, float* s) const {
    std::memcpy(p, &v[0], sizeof v[0]);
    std::memcpy(q, &v[1], sizeof v[1]);
    std::memcpy(r, &v[2], sizeof v[2]);
    std::memcpy(s, &v[3], sizeof v[3]);
  }
  /// In each group of four lanes: lanes i and j of x, then lanes k and l of y.
  template <int i, int j, int k, int l>
  static FloatX16 shuffle(const FloatX16& x, const FloatX16& y) {
    FloatX16 fours;
    for (int n = 0; n < 4; ++n) fours.v[n] = __builtin_shufflevector(x.v[n], y.v[n], i, j, k + 4, l + 4);
    return fours;
  }
  void store(float* p) const { std::memcpy(p, v, sizeof v); }
  /// table[index[i] % n] in each lane i, for a table of n = 16 or 64 floats.
  template <int n = 16>
  static FloatX16 permute(const float* table, const std::uint32_t* index) {
    float x[16];  // filled by memcpy: the table may hold integers, which a float copy could change
    for (int i = 0; i < 16; ++i) std::memcpy(&x[i], table + index[i] % n, sizeof(float));
    return load(x);
  }

  /// Writes table[index[i] % 16] for a table of 16 doubles.
  static void permute(const double* table, const std::uint32_t* index, double* to) {
    for (int i = 0; i < 16; ++i) to[i] = table[index[i] % 16];
  }

  template <class Op>
  static FloatX16 each(FloatX16 x, FloatX16 y, Op op) {
    return {op(x.v[0], y.v[0]), op(x.v[1], y.v[1]), op(x.v[2], y.v[2]), op(x.v[3], y.v[3])};
  }
  template <class Op>
  static MaskX16 compare(FloatX16 x, FloatX16 y, Op op) {
    return {op(x.v[0], y.v[0]), op(x.v[1], y.v[1]), op(x.v[2], y.v[2]), op(x.v[3], y.v[3])};
  }

  friend FloatX16 operator+(FloatX16 x, FloatX16 y) {
    return each(x, y, [](FloatX4 a, FloatX4 b) { return a + b; });
  }
  friend FloatX16 operator-(FloatX16 x, FloatX16 y) {
    return each(x, y, [](FloatX4 a, FloatX4 b) { return a - b; });
  }
  friend FloatX16 operator*(FloatX16 x, FloatX16 y) {
    return each(x, y, [](FloatX4 a, FloatX4 b) { return a * b; });
  }
  friend FloatX16 operator/(FloatX16 x, FloatX16 y) {
    return each(x, y, [](FloatX4 a, FloatX4 b) { return a / b; });
  }
  friend MaskX16 operator<=(FloatX16 x, FloatX16 y) {
    return compare(x, y, [](FloatX4 a, FloatX4 b) { return IntX4(a <= b); });
  }
  friend MaskX16 operator<(FloatX16 x, FloatX16 y) {
    return compare(x, y, [](FloatX4 a, FloatX4 b) { return IntX4(a < b); });
  }
};

inline FloatX16 min(FloatX16 x, FloatX16 y) {
  return FloatX16::each(x, y, [](FloatX4 a, FloatX4 b) { return min(a, b); });
}
inline FloatX16 max(FloatX16 x, FloatX16 y) {
  return FloatX16::each(x, y, [](FloatX4 a, FloatX4 b) { return max(a, b); });
}
inline FloatX16 fma(FloatX16 x, FloatX16 y, FloatX16 z) { return x * y + z; }
inline FloatX16 fnma(FloatX16 x, FloatX16 y, FloatX16 z) { return z - x * y; }
inline FloatX16 blend(MaskX16 mask, FloatX16 x, FloatX16 y) {
  return {mask.v[0] ? x.v[0] : y.v[0], mask.v[1] ? x.v[1] : y.v[1], mask.v[2] ? x.v[2] : y.v[2],
          mask.v[3] ? x.v[3] : y.v[3]};
}

/// x in the lanes whose bit is set, y in the others.
inline FloatX16 blend(std::uint32_t bits, FloatX16 x, FloatX16 y) {
  const int all = int(bits);
  const IntX4 four{all, all, all, all};
  const auto chosen = [&](int i) {
    return FloatX4((four & (IntX4{1, 2, 4, 8} << 4 * i)) != 0 ? IntX4(x.v[i]) : IntX4(y.v[i]));
  };
  return {chosen(0), chosen(1), chosen(2), chosen(3)};
}

/// Moves the lanes whose bit is set to the front. Writes 16 floats; those past the set lanes have any value.
inline void compress(std::uint32_t bits, FloatX16 x, float* to) {
  float from[16];
  x.store(from);
  const int n = std::popcount(bits & 0xff);
  const auto put = [&](int place, int lane) { std::memcpy(to + place, from + lane, sizeof(float)); };
  for (int i = 0; i < 8; ++i) put(i, kCompressTable.lanes[bits & 0xff][i]);
  for (int i = 0; i < 8; ++i) put(n + i, 8 + kCompressTable.lanes[bits >> 8][i]);
}

/// base + i for each set bit i, in order. Writes 16 integers; those past the set bits have any value.
inline void compress_indices(std::uint32_t bits, std::uint32_t base, std::uint32_t* to) {
  const int n = std::popcount(bits & 0xff);
  for (int i = 0; i < 8; ++i) to[i] = base + kCompressTable.lanes[bits & 0xff][i];
  for (int i = 0; i < 8; ++i) to[n + i] = base + 8 + kCompressTable.lanes[bits >> 8][i];
}

/// A bit for each of 16 integers that is not zero.
inline std::uint32_t nonzero_mask(const std::uint32_t* numbers) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 4; ++i) {
    IntX4 four;
    std::memcpy(&four, numbers + 4 * i, sizeof four);
    bits |= bits_of(four != 0) << 4 * i;
  }
  return bits;
}

/// A bit for each lane where the sign bits of both x and y are 0, or that of z, or that of w.
inline std::uint32_t nonnegative_mask(FloatX16 x, FloatX16 y, FloatX16 z, FloatX16 w) {
  const auto four = [&](int i) {
    return bits_of(((IntX4(x.v[i]) | IntX4(y.v[i])) & IntX4(z.v[i]) & IntX4(w.v[i])) >= 0) << 4 * i;
  };
  return four(0) | four(1) | four(2) | four(3);
}

/// The minimum over all lanes.
inline float reduce_min(FloatX16 x) {
  const FloatX4 four = min(min(x.v[0], x.v[1]), min(x.v[2], x.v[3]));
  const float two[2] = {four[0] < four[1] ? four[0] : four[1], four[2] < four[3] ? four[2] : four[3]};
  return two[0] < two[1] ? two[0] : two[1];
}

/// The lane of the least number among those whose bit is set, at least one, and a lower bound of that number.
inline std::uint32_t least_lane(std::uint32_t bits, FloatX16 x, float& at_least) {
  const FloatX16 some = blend(bits, x, __builtin_inff());
  at_least = reduce_min(some);
  return std::uint32_t(std::countr_zero((some <= FloatX16(at_least)).bits()));
}

inline FloatX16 sqrt(FloatX16 x) {
  for (FloatX4& quad : x.v)
    for (int i = 0; i < 4; ++i) quad[i] = std::sqrt(quad[i]);
  return x;
}
inline FloatX16 abs(FloatX16 x) {
  const auto each = [](FloatX4 a) { return FloatX4(IntX4(a) & 0x7fff'ffff); };
  return {each(x.v[0]), each(x.v[1]), each(x.v[2]), each(x.v[3])};
}

}  // namespace fastlines
