// The ends of sixteen pieces as a leaf has them, in bytes, seen along an axis: start + x·axis_x + y·axis_y + z·axis_z
// of each.
//
// Where the instruction set multiplies bytes and adds up (AVX-512 with VNNI), an axis has whole numbers, and what is
// seen is exact. So it is where pairs of bytes are multiplied and added up in 16 bits (AVX2 and SSE4.2: words.hpp).
// Elsewhere it has floats. `kWholeAxes` says which.
#pragma once

#include <cstdint>
#include <cstring>

#include "four.hpp"
#include "words.hpp"

namespace fastlines {

/// Of a leaf's 96 bytes, that of a coordinate of one end of a piece: x and y of the first ends stand in pairs, then z
/// of both ends, then x and y of the second ends.
constexpr int end_byte(int end, int axis, int piece) {
  return axis < 2 ? 64 * end + 2 * piece + axis : 32 + 2 * piece + end;
}

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)
inline constexpr bool kWholeAxes = true;
/// How long axes are: their numbers are signed bytes.
inline constexpr float kLength = 126.0f;
#elif defined(FASTLINES_IN_WORDS)
inline constexpr bool kWholeAxes = true;
/// How long axes are: 255 times the sizes of an axis's numbers, which come to 72·√3 + 1.5 at most, fits into 16 bits.
inline constexpr float kLength = 72.0f;
#else
inline constexpr bool kWholeAxes = false;
inline constexpr float kLength = 1.0f;
#endif

/// Make an axis whole by rounding, and pack its numbers: the bits of x, y, z and 0. Of one axis, or of sixteen.
template <class N>
N take_axis(N& x, N& y, N& z) {
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
    static constexpr Turn turn(end, skipped);
    return {_mm512_permutexvar_epi8(_mm512_load_si512(turn.from), _mm512_loadu_si512(ends + skipped))};
  }

  Float16 along(const Axis& axis, std::int32_t start) const {
    return _mm512_cvtepi32_ps(
        _mm512_dpbusd_epi32(_mm512_set1_epi32(start), xyz, _mm512_castps_si512(_mm512_set1_ps(axis.bytes))));
  }

 private:
  /// Where the bytes of each point come from.
  struct Turn {
    alignas(64) std::uint8_t from[4 * kWidth] = {};

    constexpr Turn(int end, int skipped) {
      for (int i = 0; i < kWidth; ++i)
        for (int k = 0; k < 3; ++k) from[4 * i + k] = std::uint8_t(end_byte(end, k, i) - skipped);
    }
  };
};

#elif !defined(FASTLINES_IN_WORDS)

struct Axis {
  float x, y, z;

  Axis(float x_, float y_, float z_, float) : x(x_), y(y_), z(z_) {}
};

struct Points16 {
  Float16 x, y, z;

  /// Those at one end, the first or the second.
  template <int end>
  static Points16 of(const std::uint8_t* ends) {
    const auto axis = [ends](int k) {
      std::uint8_t bytes[kWidth];
      for (int i = 0; i < kWidth; ++i) bytes[i] = ends[end_byte(end, k, i)];
      return Float16::bytes(bytes);
    };
    return {axis(0), axis(1), axis(2)};
  }

  Float16 along(const Axis& axis, float start) const {
    return fma(z, Float16(axis.z), fma(y, Float16(axis.y), fma(x, Float16(axis.x), Float16(start))));
  }
};

#endif

}  // namespace fastlines
