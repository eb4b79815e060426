// Batches of rays of the C interface.
#pragma once

#include "c_calls.hpp"

namespace fl::detail {

/// A batch of the C interface as one of C++.
struct RayBatch {
  Rays rays;
  PerRay radius = 0.0f;
  QueryOptions options;

  explicit RayBatch(const fl_rays* given, At at, Rank rank = Rank::t) {
    require(given, "rays");
    const std::size_t n = given->n;
    if (n > 0) require(given->origins, "rays->origins"), require(given->directions, "rays->directions");
    rays.origins = {reinterpret_cast<const Vec3*>(given->origins), n};
    rays.directions = {reinterpret_cast<const Vec3*>(given->directions), n};
    const auto each = [n](const float* values) { return std::span<const float>(values, n); };
    if (given->t_min) rays.t_min = each(given->t_min);
    if (given->t_max) rays.t_max = each(given->t_max);
    radius = given->radii ? PerRay(each(given->radii)) : PerRay(given->radius);
    rays.spread = given->spreads ? PerRay(each(given->spreads)) : PerRay(given->spread);
    rays.ignore = {given->ignore, given->n_ignore};
    rays.ignore_strands = {given->ignore_strands, given->n_ignore_strands};
    options.at = at;
    options.rank = rank;
    options.n_threads = given->n_threads;
  }
};

}  // namespace fl::detail
