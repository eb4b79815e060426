// Round cones for rays with a spread, whose reach grows along the ray as the width of a pixel does.
//
// Lines without a radius are round cones of radius 0. A tree and its layout are those of the lines: only the rays and
// the exact test are others (rays/spread_ray.hpp, round_cone_test.hpp). A query takes t at the closest approach, for
// with a spread there is no surface.
#pragma once

#include "round_cones.hpp"

namespace fastlines {

/// Round cones as a set of primitives for rays with a spread.
class SpreadCones : public RoundCones {
 public:
  using RoundCones::RoundCones;
  static constexpr const char* kKind = "spread cones";
  static constexpr bool kHasSpread = true;
};
static_assert(RayPrimitive<SpreadCones>);

}  // namespace fastlines
