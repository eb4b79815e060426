// Projects the ends of a leaf's 16 pieces, which are bytes, onto an axis: start + x·axis_x + y·axis_y + z·axis_z for
// each end.
//
// AVX-512 VNNI multiplies bytes and adds the products, so axes are integers and projections are exact. The same holds
// for AVX2 and SSE4.2, which add products of byte pairs in 16 bits (simd/int16.hpp). Elsewhere axes are floats, and
// `kIntegerAxes` is false.
#pragma once

#include <cstdint>
#include <cstring>

#include "../../layout/leaf_bytes.hpp"
#include "../../simd/float_x4.hpp"
#include "../../simd/int16.hpp"

namespace fastlines {

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)
inline constexpr bool kIntegerAxes = true;
/// The length of an axis before rounding: its components are signed bytes.
inline constexpr float kAxisLength = 126.0f;
#elif defined(FASTLINES_INT16)
inline constexpr bool kIntegerAxes = true;
/// The length of an axis before rounding. The absolute components of a rounded axis sum to at most 72·√3 + 1.5, and 255
/// times that fits into 16 bits.
inline constexpr float kAxisLength = 72.0f;
#else
inline constexpr bool kIntegerAxes = false;
inline constexpr float kAxisLength = 1.0f;
#endif

/// Round the components of an axis to integers, and return them as four bytes: x, y, z and 0. N is float for one axis,
/// or FloatX16 for 16.
template <class N>
N round_axis(N& x, N& y, N& z) {
  typedef std::int32_t Bits __attribute__((vector_size(sizeof(N))));
  constexpr float kRound = 0x1.8p23f;  // adding and subtracting it rounds to an integer
  Bits all{};
  const auto pack = [&](N& component, int shift) {
    const N sum = component + N(kRound);
    component = sum - N(kRound);
    Bits bits;
    std::memcpy(&bits, &sum, sizeof bits);
    all |= (bits & 0xff) << shift;
  };
  pack(x, 0);
  pack(y, 8);
  pack(z, 16);
  N packed;
  std::memcpy(&packed, &all, sizeof packed);
  return packed;
}

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)

/// An axis to project points onto.
struct ProjectionAxis {
  float bytes;  // x, y, z and 0 as four bytes

  ProjectionAxis(float, float, float, float bytes_) : bytes(bytes_) {}
};

/// The first or the second ends of a leaf's pieces.
struct LeafPoints {
  __m512i xyz;  // four bytes per point; the last one is multiplied by 0

  /// The first (0) or the second (1) ends of the pieces.
  template <int end>
  static LeafPoints of(const std::uint8_t* ends) {
    constexpr int skipped = end == 0 ? 0 : 32;  // one load reads 64 of the 96 bytes
    static constexpr ByteOrder order(end, skipped);
    return {_mm512_permutexvar_epi8(_mm512_load_si512(order.from), _mm512_loadu_si512(ends + skipped))};
  }

  /// The projections onto an axis.
  FloatX16 project(const ProjectionAxis& axis, std::int32_t start) const {
    return _mm512_cvtepi32_ps(
        _mm512_dpbusd_epi32(_mm512_set1_epi32(start), xyz, _mm512_castps_si512(_mm512_set1_ps(axis.bytes))));
  }

 private:
  /// The permutation that puts the bytes of each point together.
  struct ByteOrder {
    alignas(64) std::uint8_t from[4 * kSimdWidth] = {};

    constexpr ByteOrder(int end, int skipped) {
      for (int i = 0; i < kSimdWidth; ++i)
        for (int k = 0; k < 3; ++k) from[4 * i + k] = std::uint8_t(end_byte(end, k, i) - skipped);
    }
  };
};

#elif !defined(FASTLINES_INT16)

/// An axis to project points onto.
struct ProjectionAxis {
  float x, y, z;

  ProjectionAxis(float x_, float y_, float z_, float) : x(x_), y(y_), z(z_) {}
};

/// The first or the second ends of a leaf's pieces.
struct LeafPoints {
  FloatX16 x, y, z;

  /// The first (0) or the second (1) ends of the pieces.
  template <int end>
  static LeafPoints of(const std::uint8_t* ends) {
    const auto axis = [ends](int k) {
      std::uint8_t bytes[kSimdWidth];
      for (int i = 0; i < kSimdWidth; ++i) bytes[i] = ends[end_byte(end, k, i)];
      return FloatX16::bytes(bytes);
    };
    return {axis(0), axis(1), axis(2)};
  }

  /// The projections onto an axis.
  FloatX16 project(const ProjectionAxis& axis, float start) const {
    return fma(z, FloatX16(axis.z), fma(y, FloatX16(axis.y), fma(x, FloatX16(axis.x), FloatX16(start))));
  }
};

#endif

}  // namespace fastlines
