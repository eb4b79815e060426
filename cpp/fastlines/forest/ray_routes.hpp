// The tiles that each ray of a batch may have hits in, in the order in which it meets them.
#pragma once

#include <algorithm>
#include <vector>

#include "../memory/large_vector.hpp"
#include "../parallel/parallel_for.hpp"
#include "top_tree.hpp"

namespace fastlines {

/// A tile on the way of a ray, and a lower bound on the t of hits there, in units of the caller's ray.
struct RouteStep {
  std::uint32_t tile;
  float enter;
};

/// The routes of rays as compressed sparse rows: the steps of ray i are those from offsets[i] up to offsets[i + 1].
struct RayRoutes {
  std::size_t n_tiles = 0;  ///< in the forest
  LargeVector<std::int64_t> offsets;
  LargeVector<RouteStep> steps;

  std::size_t n_rays() const { return offsets.size() - 1; }
  std::span<const RouteStep> of(std::size_t ray) const {
    return {steps.data() + offsets[ray], std::size_t(offsets[ray + 1] - offsets[ray])};
  }
};

/// Whether a tile comes first on a route.
inline bool comes_first(const RouteStep& a, const RouteStep& b) {
  return a.enter != b.enter ? a.enter < b.enter : a.tile < b.tile;
}

/// The routes of all rays.
inline RayRoutes routes_of(const TopTree& top, const RayBatch& rays, unsigned n_threads, Progress& progress) {
  constexpr std::size_t rays_per_chunk = 1 << 12;
  std::vector<std::vector<RouteStep>> parts((rays.size() + rays_per_chunk - 1) / rays_per_chunk);
  RayRoutes routes{top.n_tiles(), {}, {}};
  routes.offsets.resize(rays.size() + 1);
  parallel_for_chunks(
      rays.size(), rays_per_chunk, n_threads, progress, [] { return 0; },
      [&](int, std::size_t begin, std::size_t end) {
        std::vector<RouteStep>& steps = parts[begin / rays_per_chunk];
        steps.reserve(2 * rays_per_chunk);
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t first = steps.size();
          top.for_each_on_ray(top.routed(rays[i]),
                              [&](std::uint32_t tile, float enter) { steps.push_back({tile, enter}); });
          std::sort(steps.begin() + std::ptrdiff_t(first), steps.end(),
                    [](const RouteStep& a, const RouteStep& b) { return comes_first(a, b); });
          routes.offsets[i + 1] = std::int64_t(steps.size() - first);
        }
      });
  for (std::size_t i = 0; i < rays.size(); ++i) routes.offsets[i + 1] += routes.offsets[i];
  routes.steps.reserve(std::size_t(routes.offsets[rays.size()]));
  for (std::vector<RouteStep>& part : parts) {
    routes.steps.insert(routes.steps.end(), part.begin(), part.end());
    part = {};
  }
  return routes;
}

}  // namespace fastlines
