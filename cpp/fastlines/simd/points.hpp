// Sixteen points of bytes, seen along an axis: start + x·axis_x + y·axis_y + z·axis_z of each.
//
// Where the instruction set multiplies bytes and adds up (AVX-512 with VNNI), an axis has whole numbers of up to 127,
// and what is seen is exact. Elsewhere it has floats. `kWholeAxes` says which.
#pragma once

#include "four.hpp"
#include "simd.hpp"

namespace fastlines {

#if defined(__AVX512VNNI__) && defined(__AVX512VBMI__) && !defined(FASTLINES_PORTABLE)

inline constexpr bool kWholeAxes = true;

struct Axis {
  std::int32_t bytes;  // x, y, z and 0
};

/// The axes in the first two lanes, made whole by rounding; their numbers are at most 127.
inline void take_axes(Float4& x, Float4& y, Float4& z, Axis& u, Axis& v) {
  constexpr float kWhole = 0x1.8p23f;  // of a sum with it only whole numbers are left
  const auto bytes = [=](Float4& a) {
    const Float4 sum = a + four(kWhole);
    a = sum - four(kWhole);
    return Int4(sum) & 0xff;
  };
  const Int4 packed = bytes(x) | bytes(y) << 8 | bytes(z) << 16;
  u.bytes = packed[0];
  v.bytes = packed[1];
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
    return _mm512_cvtepi32_ps(_mm512_dpbusd_epi32(_mm512_set1_epi32(start), xyz, _mm512_set1_epi32(axis.bytes)));
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
};

/// The axes in the first two lanes.
inline void take_axes(const Float4& x, const Float4& y, const Float4& z, Axis& u, Axis& v) {
  u = {x[0], y[0], z[0]};
  v = {x[1], y[1], z[1]};
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
