// A hit, the order of hits, and hits as arrays. The columns of a hit have one order everywhere:
// t, prim, u, distance, t_out.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

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

  bool operator<(const Hit& other) const { return precedes(t, prim, other.t, other.prim); }
};

/// The order of a ray's hits by their distance from the ray; of equal ones by t, and then by id.
struct ByDistance {
  bool operator()(const Hit& a, const Hit& b) const {
    return a.distance != b.distance ? a.distance < b.distance : a < b;
  }
};

/// Keep the k hits of a ray that are nearest to it, in the order `ByDistance`.
inline void keep_nearest(std::vector<Hit>& hits, std::size_t k) {
  const std::size_t n = std::min(hits.size(), k);
  std::partial_sort(hits.begin(), hits.begin() + std::ptrdiff_t(n), hits.end(), ByDistance{});
  hits.resize(n);
}

/// Hits as one array per property; t_out may be null.
template <class Prim>
struct HitColumnsOf {
  float* t;
  Prim* prim;
  float *u, *distance, *t_out;

  void set(std::size_t i, const Hit& hit) const {
    t[i] = hit.t;
    prim[i] = Prim(hit.prim);
    u[i] = hit.u;
    distance[i] = hit.distance;
    if (t_out) t_out[i] = hit.t_out;
  }

  /// The columns from hit i on.
  HitColumnsOf from(std::size_t i) const { return {t + i, prim + i, u + i, distance + i, t_out ? t_out + i : nullptr}; }

  /// Move hit i, without its t_out, to place j < i; hits from j on move up by one.
  void move(std::size_t i, std::size_t j) const {
    std::rotate(t + j, t + i, t + i + 1);
    std::rotate(prim + j, prim + i, prim + i + 1);
    std::rotate(u + j, u + i, u + i + 1);
    std::rotate(distance + j, distance + i, distance + i + 1);
  }

  /// Whether hit i precedes hit j.
  bool precedes(std::size_t i, std::size_t j) const { return fastlines::precedes(t[i], prim[i], t[j], prim[j]); }
};
using HitColumns = HitColumnsOf<std::int64_t>;
using ListColumns = HitColumnsOf<std::uint32_t>;

}  // namespace fastlines
