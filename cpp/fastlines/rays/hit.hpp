// A hit, and hits as arrays. The columns of a hit have one order everywhere: t, prim, u, distance, t_out.
//
// GPUs compile this file too (device/kernels.hpp).
#pragma once

#include <cstdint>

#include "../math/vec.hpp"
#include "hit_order.hpp"

namespace fastlines {

/// A hit in units of the caller's ray; a miss by default.
struct Hit {
  float t = kInfinity;
  std::int64_t prim = -1;
  float u = 0.0f;
  float distance = kInfinity;
  float t_out = kInfinity;
};

/// Hits as one array per property; t_out may be null.
template <class Prim>
struct HitColumnsOf {
  float* t;
  Prim* prim;
  float *u, *distance, *t_out;

  /// Hit i, without its t_out.
  Hit operator[](std::uint64_t i) const { return {t[i], std::int64_t(prim[i]), u[i], distance[i]}; }

  void set(std::uint64_t i, const Hit& hit) const {
    t[i] = hit.t;
    prim[i] = Prim(hit.prim);
    u[i] = hit.u;
    distance[i] = hit.distance;
    if (t_out) t_out[i] = hit.t_out;
  }

  /// The columns from hit i on.
  HitColumnsOf from(std::uint64_t i) const {
    return {t + i, prim + i, u + i, distance + i, t_out ? t_out + i : nullptr};
  }

  /// Whether hit i precedes hit j.
  bool precedes(std::uint64_t i, std::uint64_t j) const { return fastlines::precedes(t[i], prim[i], t[j], prim[j]); }
};
using HitColumns = HitColumnsOf<std::int64_t>;
using ListColumns = HitColumnsOf<std::uint32_t>;

}  // namespace fastlines
