// Sixteen of up to 64 rays, each as often as it is wanted, in lanes: what an exact test of sixteen pieces, each against
// a ray of its own, reads of them.
//
// Either each number is looked up in the vectors that hold it for all rays, or each ray has a row of its numbers, and
// sixteen rows are turned. AVX-512 looks up among 64 rays with two instructions and a choice; where a vector holds
// less, rows are no dearer.
#pragma once

#include "ray_views.hpp"

namespace fastlines {

/// What sixteen rays are picked from.
class RayGather {
 public:
  /// Make ready for the sixteen rays in lanes from `first` on.
  void load(const RayGroup& rays, int first) {
    if constexpr (kTransposes) {
      const float* const columns[] = {rays.o[0], rays.o[1], rays.o[2], rays.t_min,    //
                                      rays.u[0], rays.u[1], rays.u[2], rays.t_max,    //
                                      rays.v[0], rays.v[1], rays.v[2], rays.radius2,  //
                                      rays.r[0], rays.r[1], rays.r[2], rays.tie_tolerance};
      transpose_columns<16>([&](int k) { return columns[k] + first; }, records_ + first);
    }
  }

  /// Those with these indices of lanes [first, first + n), n as for PermutedRays, as is F.
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
