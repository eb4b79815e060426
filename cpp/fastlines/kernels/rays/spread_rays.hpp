// Groups and views of rays with a spread: those of other rays, and two more columns. Kernels name them by the set of
// primitives that they run on, so that the code for other rays stays the same.
#pragma once

#include <type_traits>

#include "../../primitives/round_cone_test.hpp"
#include "../../rays/spread_ray.hpp"
#include "ray_gather.hpp"

namespace fastlines {

/// A group of rays with a spread. `cull_radius` and `tie_tolerance` include it.
struct SpreadRayGroup : RayGroup {
  float spread[kGroupSize], spread_at_0[kGroupSize];

  /// Prepare the rays with these ids, 1 to 64 of them.
  void fill(const RayBatch& rays, const Frame& frame, int n_rays, const std::uint32_t* ids) {
    RayGroup::fill(rays, frame, n_rays, ids);
    const int padded = round_up_to_width(n);
    broadcast_or_gather(rays.spread, padded, spread);
    for (int i = 0; i < padded; ++i) {
      const SpreadInFrame of(spread[i], {o[0][i], o[1][i], o[2][i]}, {r[0][i], r[1][i], r[2][i]}, t0[i], frame.scale);
      spread_at_0[i] = of.at_0;
      cull_radius[i] += of.cull_growth;
      tie_tolerance[i] += of.tie_tolerance;
    }
    fill_limits(rays);
  }

  /// Copy a packet of another group, as `RayGroup::copy` does.
  template <bool with_t_ray>
  void copy(int to, const SpreadRayGroup& from, int first) {
    RayGroup::copy<with_t_ray>(to, from, first);
    std::memcpy(spread + to, from.spread + first, kSimdWidth * sizeof *spread);
    std::memcpy(spread_at_0 + to, from.spread_at_0 + first, kSimdWidth * sizeof *spread_at_0);
  }
};

/// The ray in one lane.
struct SpreadLaneView : LaneView {
  float spread, spread_at_0;

  SpreadLaneView(const SpreadRayGroup& lanes, int i)
      : LaneView(lanes, i), spread(lanes.spread[i]), spread_at_0(lanes.spread_at_0[i]) {}
};

/// 16 rays by index: the view `Rays` of other rays, and the two columns.
template <class F, class Rays>
struct SpreadRays : Rays {
  F spread, spread_at_0;
};

/// A copy of the rays of a group in the form that gathering needs.
class SpreadRayGather : public RayGather {
 public:
  /// A view of the 16 rays first + index[i], index[i] < n.
  template <class F, int n>
  [[gnu::always_inline]] auto gather(const SpreadRayGroup& rays, int first, const std::uint32_t* index) const {
    const auto column = [=](const float* from) {
      float values[kSimdWidth];
      for (int i = 0; i < kSimdWidth; ++i) values[i] = from[index[i]];
      return F::load(values);
    };
    using Rays = decltype(RayGather::gather<F, n>(rays, first, index));
    return SpreadRays<F, Rays>{RayGather::gather<F, n>(rays, first, index), column(rays.spread + first),
                               column(rays.spread_at_0 + first)};
  }
};
static_assert(HasSpread<SpreadLaneView> && !HasSpread<LaneView>);

/// The groups and views of the rays of queries on P.
template <class P>
using RayGroupOf = std::conditional_t<kHasSpread<P>, SpreadRayGroup, RayGroup>;
template <class P>
using LaneViewOf = std::conditional_t<kHasSpread<P>, SpreadLaneView, LaneView>;
template <class P>
using RayGatherOf = std::conditional_t<kHasSpread<P>, SpreadRayGather, RayGather>;

}  // namespace fastlines
