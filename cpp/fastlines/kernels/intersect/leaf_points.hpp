// The ends of sixteen pieces as a leaf has them, in bytes, seen along an axis: start + x·axis_x + y·axis_y + z·axis_z
// of each.
//
// Where the instruction set multiplies bytes and adds up (AVX-512 with VNNI), an axis has whole numbers, and what is
// seen is exact. So it is where pairs of bytes are multiplied and added up in 16 bits (AVX2 and SSE4.2: words.hpp).
// Elsewhere it has floats. `kIntegerAxes` says which.
#pragma once

#include <cstdint>
#include <cstring>

#include "../../layout/leaf_bytes.hpp"
#include "../../simd/float_x4.hpp"
#include "../../simd/int16.hpp"

namespace fastlines {

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)
inline constexpr bool kIntegerAxes = true;
/// How long axes are: their numbers are signed bytes.
inline constexpr float kAxisLength = 126.0f;
#elif defined(FASTLINES_INT16)
inline constexpr bool kIntegerAxes = true;
/// How long axes are: 255 times the sizes of an axis's numbers, which come to 72·√3 + 1.5 at most, fits into 16 bits.
inline constexpr float kAxisLength = 72.0f;
#else
inline constexpr bool kIntegerAxes = false;
inline constexpr float kAxisLength = 1.0f;
#endif

/// Make an axis whole by rounding, and pack its numbers: the bits of x, y, z and 0. Of one axis, or of sixteen.
template <class N>
N round_axis(N& x, N& y, N& z) {
  typedef std::int32_t Bits __attribute__((vector_size(sizeof(N))));
  constexpr float kWhole = 0x1.8p23f;  // of a sum with it only whole numbers are left
  Bits all{};
  const auto pack = [&](N& number, int place) {
    const N sum = number + N(kWhole);
    number = sum - N(kWhole);
    Bits bits;
    std::memcpy(&bits, &sum, sizeof bits);
    all |= (bits & 0xff) << place;
  };
  pack(x, 0);
  pack(y, 8);
  pack(z, 16);
  N packed;
  std::memcpy(&packed, &all, sizeof packed);
  return packed;
}

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)

struct Axis {
  float bytes;  // the bits of x, y, z and 0

  Axis(float, float, float, float bytes_) : bytes(bytes_) {}
};

struct Points16 {
  __m512i xyz;  // four bytes a point, of which the last counts for nothing

  /// Those at one end, the first or the second.
  template <int end>
  static Points16 of(const std::uint8_t* ends) {
    constexpr int skipped = end == 0 ? 0 : 32;  // a load takes in 64 of 96
    static constexpr ByteOrder order(end, skipped);
    return {_mm512_permutexvar_epi8(_mm512_load_si512(order.from), _mm512_loadu_si512(ends + skipped))};
  }

  FloatX16 along(const Axis& axis, std::int32_t start) const {
    return _mm512_cvtepi32_ps(
        _mm512_dpbusd_epi32(_mm512_set1_epi32(start), xyz, _mm512_castps_si512(_mm512_set1_ps(axis.bytes))));
  }

 private:
  /// Where the bytes of each point come from.
  struct ByteOrder {
    alignas(64) std::uint8_t from[4 * kSimdWidth] = {};

    constexpr ByteOrder(int end, int skipped) {
      for (int i = 0; i < kSimdWidth; ++i)
        for (int k = 0; k < 3; ++k) from[4 * i + k] = std::uint8_t(end_byte(end, k, i) - skipped);
    }
  };
};

#elif !defined(FASTLINES_INT16)

struct Axis {
  float x, y, z;

  Axis(float x_, float y_, float z_, float) : x(x_), y(y_), z(z_) {}
};

struct Points16 {
  FloatX16 x, y, z;

  /// Those at one end, the first or the second.
  template <int end>
  static Points16 of(const std::uint8_t* ends) {
    const auto axis = [ends](int k) {
      std::uint8_t bytes[kSimdWidth];
      for (int i = 0; i < kSimdWidth; ++i) bytes[i] = ends[end_byte(end, k, i)];
      return FloatX16::bytes(bytes);
    };
    return {axis(0), axis(1), axis(2)};
  }

  FloatX16 along(const Axis& axis, float start) const {
    return fma(z, FloatX16(axis.z), fma(y, FloatX16(axis.y), fma(x, FloatX16(axis.x), FloatX16(start))));
  }
};

#endif

}  // namespace fastlines
