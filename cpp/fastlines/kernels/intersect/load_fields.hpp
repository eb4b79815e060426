// Gathers the fields of 16 primitives by index, one primitive a lane, for the exact test.
#pragma once

#include "../../layout/wide_bvh.hpp"
#include "../../primitives/segment_test.hpp"
#include "../../simd/transpose.hpp"

namespace fastlines {

/// The fields of the 16 primitives prim_of(0), …, prim_of(15), in the frame.
template <RayPrimitive P, class PrimOf>
[[gnu::always_inline]] inline Fields<P, FloatX16> load_fields(const WideBvhView<P>& tree, const PrimOf& prim_of) {
  constexpr int n_floats = sizeof(typename P::Item) / sizeof(float);
  const float* rows[kSimdWidth];
  for (int j = 0; j < kSimdWidth; ++j) rows[j] = reinterpret_cast<const float*>(tree.items + prim_of(j));
  FloatX16 floats[n_floats];
  transpose_rows(rows, floats);
  return P::fields(floats, tree.frame);
}

}  // namespace fastlines
