// Sixteen points of bytes, seen along an axis: start + x·axis_x + y·axis_y + z·axis_z of each.
//
// Where the instruction set multiplies bytes and adds up (AVX-512 with VNNI), an axis has whole numbers of up to 127,
// and what is seen is exact. Elsewhere it has floats. `kWholeAxes` says which.
#pragma once

#include <bit>
#include <cstdint>

#include "four.hpp"
#include "simd.hpp"

namespace fastlines {

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)

inline constexpr bool kWholeAxes = true;

struct Axis {
  float bytes;  // the bits of x, y, z and 0

  Axis(float, float, float, float bytes_) : bytes(bytes_) {}
};

/// Make an axis whole by rounding, and pack its numbers, which are at most 127; of one, and of sixteen.
inline float take_axis(float& x, float& y, float& z) {
  constexpr float kWhole = 0x1.8p23f;  // of a sum with it only whole numbers are left
  const auto byte = [=](float& a) {
    const float sum = a + kWhole;
    a = sum - kWhole;
    return std::bit_cast<std::uint32_t>(sum) & 0xff;
  };
  const std::uint32_t low = byte(x), middle = byte(y), high = byte(z);
  return std::bit_cast<float>(low | middle << 8 | high << 16);
}
inline Float16 take_axis(Float16& x, Float16& y, Float16& z) {
  const auto byte = [](Float16& a) {
    const __m512i whole = _mm512_cvtps_epi32(a.a);
    a = _mm512_cvtepi32_ps(whole);
    return _mm512_and_si512(whole, _mm512_set1_epi32(0xff));
  };
  const __m512i low = byte(x), middle = byte(y), high = byte(z);
  return _mm512_castsi512_ps(
      _mm512_or_si512(low, _mm512_or_si512(_mm512_slli_epi32(middle, 8), _mm512_slli_epi32(high, 16))));
}

struct Points16 {
  __m512i xyz;  // four bytes a point, of which the last counts for nothing

  /// Of six rows, those from `row` on: 0 or 3.
  template <int row>
  static Points16 of(const std::uint8_t* rows) {
    constexpr int skipped = row == 0 ? 0 : 2;  // for a load takes in four
    static constexpr Turn turn(row - skipped);
    return {_mm512_permutexvar_epi8(_mm512_load_si512(turn.from), _mm512_loadu_si512(rows + skipped * kWidth))};
  }

  Float16 along(const Axis& axis, std::int32_t start) const {
    return _mm512_cvtepi32_ps(
        _mm512_dpbusd_epi32(_mm512_set1_epi32(start), xyz, _mm512_castps_si512(_mm512_set1_ps(axis.bytes))));
  }

 private:
  /// Where the bytes of each point come from.
  struct Turn {
    alignas(64) std::uint8_t from[4 * kWidth] = {};

    constexpr explicit Turn(int row) {
      for (int i = 0; i < kWidth; ++i)
        for (int k = 0; k < 3; ++k) from[4 * i + k] = std::uint8_t((row + k) * kWidth + i);
    }
  };
};

#else

inline constexpr bool kWholeAxes = false;

struct Axis {
  float x, y, z;

  Axis(float x_, float y_, float z_, float) : x(x_), y(y_), z(z_) {}
};

template <class N>
N take_axis(N&, N&, N&) {
  return 0.0f;
}

struct Points16 {
  Float16 x, y, z;

  /// Of six rows, those from `row` on: 0 or 3.
  template <int row>
  static Points16 of(const std::uint8_t* rows) {
    const auto at = [rows](int k) { return Float16::bytes(rows + (row + k) * kWidth); };
    return {at(0), at(1), at(2)};
  }

  Float16 along(const Axis& axis, float start) const {
    return fma(z, Float16(axis.z), fma(y, Float16(axis.y), fma(x, Float16(axis.x), Float16(start))));
  }
};

#endif

}  // namespace fastlines
