// The exact test of a box, by slabs: the ray hits if it is inside between all three pairs of planes at once.
//
// A ray that is nearly parallel to a pair of planes may lie in one of them. Where it crosses that plane is then
// rounding noise, so the pair is moved apart by the rounding of coordinates: a box holds its faces.
#pragma once

#include "closest_approach.hpp"

namespace fastlines {

/// Where a ray enters and leaves a box within its bounds, and whether it does.
template <class N>
struct BoxHit {
  N t, t_out;
  MaskOf<N> hit;
};

/// Test a ray and a box that is grown on all sides. The fields are its low and its high corner, in the frame.
template <class N, class R, class V>
[[gnu::always_inline]] inline BoxHit<N> meet_box(const R& ray, const V& fields, const N& grow) {
  const N zero = 0.0f, one = 1.0f, nearly_parallel = 0x1p-20f, rounding = 0x1p-22f;
  N t = ray.t_min, t_out = ray.t_max;
  for (int k = 0; k < 3; ++k) {
    const N r = ray.r[k], o = ray.o[k];
    const auto back = r < zero;
    const N inverse = blend(back, zero - one, one) / max(abs(r), N(1e-18f));
    const N margin = blend(abs(r) < nearly_parallel, grow + rounding, grow);
    const N to_low = ((fields[k] - margin) - o) * inverse, to_high = ((fields[3 + k] + margin) - o) * inverse;
    t = max(t, blend(back, to_high, to_low));
    t_out = min(t_out, blend(back, to_low, to_high));
  }
  return {t, t_out, t <= t_out};
}

}  // namespace fastlines
