// Sixteen floats as four vectors of four, in the compiler's own vector types: SSE4.2, NEON, and whatever else there is.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "four.hpp"
#include "packing.hpp"

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

using Quad = float __attribute__((vector_size(16)));
using IntQuad = std::int32_t __attribute__((vector_size(16)));

/// The signs of four lanes as bits.
inline std::uint32_t bits_of(IntQuad mask) {
#if defined(__SSE4_2__) && !defined(FASTLINES_PORTABLE)
  return std::uint32_t(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#elif defined(__ARM_NEON) && !defined(FASTLINES_PORTABLE)
  const uint32x4_t weights = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(reinterpret_cast<uint32x4_t>(mask), weights));
#else
  return std::uint32_t((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

inline Quad quad_of_bytes(const std::uint8_t* p) {
#if defined(__SSE4_2__) && !defined(FASTLINES_PORTABLE)
  std::int32_t four;
  std::memcpy(&four, p, 4);
  return _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(four)));
#elif defined(__ARM_NEON) && !defined(FASTLINES_PORTABLE)
  std::uint32_t four;
  std::memcpy(&four, p, 4);
  return vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(vcreate_u8(four)))));
#else
  return Quad{float(p[0]), float(p[1]), float(p[2]), float(p[3])};
#endif
}

struct Mask16 {
  IntQuad v[4];
  std::uint32_t bits() const { return bits_of(v[0]) | bits_of(v[1]) << 4 | bits_of(v[2]) << 8 | bits_of(v[3]) << 12; }
  friend Mask16 operator&(Mask16 x, Mask16 y) {
    return {x.v[0] & y.v[0], x.v[1] & y.v[1], x.v[2] & y.v[2], x.v[3] & y.v[3]};
  }
  friend Mask16 operator|(Mask16 x, Mask16 y) {
    return {x.v[0] | y.v[0], x.v[1] | y.v[1], x.v[2] | y.v[2], x.v[3] | y.v[3]};
  }
};

struct Float16 {
  Quad v[4];
  static constexpr int kRegisters = 4;
#if defined(FASTLINES_TALLY)
  static constexpr int kLooksUp = 64;  // steps are counted as AVX-512 takes them
#else
  static constexpr int kLooksUp = 0;  // look_up is not worth its time
#endif

  Float16() = default;
  Float16(Quad a, Quad b, Quad c, Quad d) : v{a, b, c, d} {}
  Float16(float x) : v{Quad{x, x, x, x}, Quad{x, x, x, x}, Quad{x, x, x, x}, Quad{x, x, x, x}} {}

  static Float16 load(const float* p) {
    Float16 x;
    std::memcpy(x.v, p, sizeof x.v);
    return x;
  }
  static Float16 bytes(const std::uint8_t* p) {
    return {quad_of_bytes(p), quad_of_bytes(p + 4), quad_of_bytes(p + 8), quad_of_bytes(p + 12)};
  }
  /// Lane k of four, in all lanes.
  template <int k>
  static Float16 spread(const Quad& x) {
    return {x[k]};
  }
  /// Four numbers of each of four rows, side by side; and back.
  static Float16 of_rows(const float* p, const float* q, const float* r, const float* s) {
    return {four(p), four(q), four(r), four(s)};
  }
  void store_rows(float* p, float* q, float* r, float* s) const {
    std::memcpy(p, &v[0], sizeof v[0]);
    std::memcpy(q, &v[1], sizeof v[1]);
    std::memcpy(r, &v[2], sizeof v[2]);
    std::memcpy(s, &v[3], sizeof v[3]);
  }
  /// Lanes i and j of each four of x, then k and l of those of y.
  template <int i, int j, int k, int l>
  static Float16 of_fours(const Float16& x, const Float16& y) {
    Float16 fours;
    for (int n = 0; n < 4; ++n) fours.v[n] = __builtin_shufflevector(x.v[n], y.v[n], i, j, k + 4, l + 4);
    return fours;
  }
  void store(float* p) const { std::memcpy(p, v, sizeof v); }
  /// Of the numbers of a table, 16 or 64, those with these indices, of which no higher bits count.
  template <int n = 16>
  static Float16 look_up(const float* table, const std::uint32_t* index) {
    float x[16];  // copied as bytes, for the table may hold other numbers
    for (int i = 0; i < 16; ++i) std::memcpy(&x[i], table + index[i] % n, sizeof(float));
    return load(x);
  }

  /// The same of a table of sixteen doubles, which are written.
  static void look_up(const double* table, const std::uint32_t* index, double* to) {
    for (int i = 0; i < 16; ++i) to[i] = table[index[i] % 16];
  }

  template <class Op>
  static Float16 each(Float16 x, Float16 y, Op op) {
    return {op(x.v[0], y.v[0]), op(x.v[1], y.v[1]), op(x.v[2], y.v[2]), op(x.v[3], y.v[3])};
  }
  template <class Op>
  static Mask16 compare(Float16 x, Float16 y, Op op) {
    return {op(x.v[0], y.v[0]), op(x.v[1], y.v[1]), op(x.v[2], y.v[2]), op(x.v[3], y.v[3])};
  }

  friend Float16 operator+(Float16 x, Float16 y) {
    return each(x, y, [](Quad a, Quad b) { return a + b; });
  }
  friend Float16 operator-(Float16 x, Float16 y) {
    return each(x, y, [](Quad a, Quad b) { return a - b; });
  }
  friend Float16 operator*(Float16 x, Float16 y) {
    return each(x, y, [](Quad a, Quad b) { return a * b; });
  }
  friend Float16 operator/(Float16 x, Float16 y) {
    return each(x, y, [](Quad a, Quad b) { return a / b; });
  }
  friend Mask16 operator<=(Float16 x, Float16 y) {
    return compare(x, y, [](Quad a, Quad b) { return IntQuad(a <= b); });
  }
  friend Mask16 operator<(Float16 x, Float16 y) {
    return compare(x, y, [](Quad a, Quad b) { return IntQuad(a < b); });
  }
};

inline Float16 min(Float16 x, Float16 y) {
  return Float16::each(x, y, [](Quad a, Quad b) { return a < b ? a : b; });
}
inline Float16 max(Float16 x, Float16 y) {
  return Float16::each(x, y, [](Quad a, Quad b) { return a > b ? a : b; });
}
inline Float16 fma(Float16 x, Float16 y, Float16 z) { return x * y + z; }
inline Float16 fnma(Float16 x, Float16 y, Float16 z) { return z - x * y; }
inline Float16 select(Mask16 mask, Float16 x, Float16 y) {
  return {mask.v[0] ? x.v[0] : y.v[0], mask.v[1] ? x.v[1] : y.v[1], mask.v[2] ? x.v[2] : y.v[2],
          mask.v[3] ? x.v[3] : y.v[3]};
}

/// x in the lanes of these bits, y in the others.
inline Float16 choose(std::uint32_t bits, Float16 x, Float16 y) {
  const int all = int(bits);
  const IntQuad four{all, all, all, all};
  const auto chosen = [&](int i) {
    return Quad((four & (IntQuad{1, 2, 4, 8} << 4 * i)) != 0 ? IntQuad(x.v[i]) : IntQuad(y.v[i]));
  };
  return {chosen(0), chosen(1), chosen(2), chosen(3)};
}

/// The lanes of these bits, one after the other; writes sixteen.
inline void pack(std::uint32_t bits, Float16 x, float* to) {
  float from[16];
  x.store(from);
  const int n = std::popcount(bits & 0xff);
  const auto put = [&](int place, int lane) { std::memcpy(to + place, from + lane, sizeof(float)); };
  for (int i = 0; i < 8; ++i) put(i, kPacking.lanes[bits & 0xff][i]);
  for (int i = 0; i < 8; ++i) put(n + i, 8 + kPacking.lanes[bits >> 8][i]);
}

/// The numbers of these bits, plus `base`; writes sixteen.
inline void pack_numbers(std::uint32_t bits, std::uint32_t base, std::uint32_t* to) {
  const int n = std::popcount(bits & 0xff);
  for (int i = 0; i < 8; ++i) to[i] = base + kPacking.lanes[bits & 0xff][i];
  for (int i = 0; i < 8; ++i) to[n + i] = base + 8 + kPacking.lanes[bits >> 8][i];
}

/// Which of sixteen whole numbers are not zero.
inline std::uint32_t not_zero(const std::uint32_t* numbers) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 4; ++i) {
    IntQuad four;
    std::memcpy(&four, numbers + 4 * i, sizeof four);
    bits |= bits_of(four != 0) << 4 * i;
  }
  return bits;
}

/// The lanes in which x and y, or z, or w are not negative.
inline std::uint32_t not_negative(Float16 x, Float16 y, Float16 z, Float16 w) {
  const auto four = [&](int i) {
    return bits_of(((IntQuad(x.v[i]) | IntQuad(y.v[i])) & IntQuad(z.v[i]) & IntQuad(w.v[i])) >= 0) << 4 * i;
  };
  return four(0) | four(1) | four(2) | four(3);
}

/// The least of all lanes.
inline float least(Float16 x) {
  const auto less = [](Quad a, Quad b) { return a < b ? a : b; };
  const Quad four = less(less(x.v[0], x.v[1]), less(x.v[2], x.v[3]));
  const float two[2] = {four[0] < four[1] ? four[0] : four[1], four[2] < four[3] ? four[2] : four[3]};
  return two[0] < two[1] ? two[0] : two[1];
}

inline Float16 sqrt(Float16 x) {
  for (Quad& quad : x.v)
    for (int i = 0; i < 4; ++i) quad[i] = std::sqrt(quad[i]);
  return x;
}
inline Float16 abs(Float16 x) {
  const auto each = [](Quad a) { return Quad(IntQuad(a) & 0x7fff'ffff); };
  return {each(x.v[0]), each(x.v[1]), each(x.v[2]), each(x.v[3])};
}

}  // namespace fastlines
