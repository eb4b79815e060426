// Sixteen segments that lie anywhere, as the exact test sees them.
#pragma once

#include "../layout/wide.hpp"
#include "../simd/rows.hpp"

namespace fastlines {

/// Starts and end − start, in the frame, of the segments prim(0), … prim(15).
template <class Prim>
[[gnu::always_inline]] inline void take_sixteen(const WideView& tree, const Prim& prim, Float16 (&start)[3],
                                                Float16 (&along)[3]) {
  static_assert(sizeof(Segment) == 6 * sizeof(float));
  const float* rows[kWidth];
  for (int j = 0; j < kWidth; ++j) rows[j] = reinterpret_cast<const float*>(tree.segments + prim(j));
  Float16 ends[6];
  turn_rows(rows, ends);
  for (int k = 0; k < 3; ++k) {
    const Float16 centre = tree.frame.centre[k], scale = tree.frame.scale;
    start[k] = (ends[k] - centre) * scale;
    along[k] = (ends[3 + k] - centre) * scale - start[k];
  }
}

}  // namespace fastlines
