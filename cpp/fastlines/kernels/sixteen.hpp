// Up to sixteen segments in lanes, as the caller gave them.
#pragma once

#include "../query/frame.hpp"
#include "../simd/simd.hpp"

namespace fastlines {

/// Lanes that were never put hold zeros.
struct Sixteen {
  alignas(64) float p[3][kWidth] = {}, q[3][kWidth] = {};

  void put(int lane, const Segment& segment) {
    for (int k = 0; k < 3; ++k) {
      p[k][lane] = segment.p[k];
      q[k][lane] = segment.q[k];
    }
  }

  /// Their starts and end − start, in the frame.
  template <class F>
  [[gnu::always_inline]] void in(const Frame& frame, F (&start)[3], F (&along)[3]) const {
    for (int k = 0; k < 3; ++k) {
      const F centre = frame.centre[k], scale = frame.scale;
      start[k] = (F::load(p[k]) - centre) * scale;
      along[k] = (F::load(q[k]) - centre) * scale - start[k];
    }
  }
};

}  // namespace fastlines
