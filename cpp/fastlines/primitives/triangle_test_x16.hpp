// The exact test of 16 triangles at once: what it does for lanes that need float64.
#pragma once

#include <bit>
#include <cstdint>

#include "../simd/float_x16.hpp"
#include "triangle_test.hpp"

namespace fastlines {

/// Replace the results of the lanes in `unsure` by those of float64.
inline void meet_triangles_in_double(const FloatX16 (&x)[9], TriangleHit<FloatX16>& to, MaskX16 unsure) {
  alignas(64) float columns[9][kSimdWidth], t[kSimdWidth], hit[kSimdWidth];
  for (int k = 0; k < 9; ++k) x[k].store(columns[k]);
  to.t.store(t);
  blend(to.hit, FloatX16(1.0f), FloatX16(0.0f)).store(hit);
  for (std::uint32_t bits = unsure.bits(); bits; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    float corner[9];
    for (int k = 0; k < 9; ++k) corner[k] = columns[k][i];
    const TriangleHit<float> found = meet_triangle_in_double(corner);
    t[i] = found.t;
    hit[i] = found.hit ? 1.0f : 0.0f;
  }
  to.t = FloatX16::load(t);
  to.hit = FloatX16(0.0f) < FloatX16::load(hit);
}

}  // namespace fastlines
