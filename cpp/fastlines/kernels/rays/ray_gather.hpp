// Gathers 16 of up to 64 rays by index, repeats allowed, for an exact test of 16 pieces, each against its own ray.
//
// There are two ways: permute each column of the group, or keep a record per ray and transpose 16 records. AVX-512
// permutes 64 rays with two instructions and a blend; with narrower vectors, transposing records is as fast.
#pragma once

#include "ray_views.hpp"

namespace fastlines {

/// A copy of the rays of a group in the form that gathering needs.
class RayGather {
 public:
  /// Load the packet at `first`.
  void load(const RayGroup& rays, int first) {
    if constexpr (kTransposes) {
      const float* const columns[] = {rays.o[0], rays.o[1], rays.o[2], rays.t_min,    //
                                      rays.u[0], rays.u[1], rays.u[2], rays.t_max,    //
                                      rays.v[0], rays.v[1], rays.v[2], rays.radius2,  //
                                      rays.r[0], rays.r[1], rays.r[2], rays.tie_tolerance};
      transpose_columns<16>([&](int k) { return columns[k] + first; }, records_ + first);
    }
  }

  /// A view of the 16 rays first + index[i], index[i] < n. For F and n see `PermutedRays`.
  template <class F, int n>
  [[gnu::always_inline]] auto gather(const RayGroup& rays, int first, const std::uint32_t* index) const {
    if constexpr (kTransposes)
      return TransposedRays<F>(records_ + first, index);
    else
      return PermutedRays<F, n>(rays, first, index);
  }

 private:
  static constexpr bool kTransposes = FloatX16::kMaxPermuteTable < kGroupSize;
  RayRecord records_[kTransposes ? kGroupSize : 1];
};

}  // namespace fastlines
