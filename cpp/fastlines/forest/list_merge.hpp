// Merges the lists of hits that tiles have found into one list for each ray.
#pragma once

#include <vector>

#include "../query/ray_collectors.hpp"
#include "best_hits.hpp"
#include "tile_walk.hpp"

namespace fastlines {

/// The lists of a tile: those of its j-th ray are from offsets[j] up to offsets[j + 1], in the order that `Keep` gives.
struct TileLists {
  std::span<const std::int64_t> offsets;
  HitColumns hits;
  GlobalIds ids;
};

/// The rays that each tile is queried with: all whose routes lead there.
class TileRays {
 public:
  TileRays(const TopTree& top, const RayBatch& rays, unsigned n_threads, Progress& progress)
      : routes_(routes_of(top, rays, n_threads, progress)), place_(routes_.steps.size()), of_tile_(top.n_tiles()) {
    std::vector<std::size_t> n(top.n_tiles());
    for (const RouteStep& step : routes_.steps) ++n[step.tile];
    for (std::size_t tile = 0; tile < n.size(); ++tile) of_tile_[tile].reserve(n[tile]);
    for (const std::uint32_t ray : coherent_order(rays))
      for (std::int64_t i = routes_.offsets[ray]; i < routes_.offsets[ray + 1]; ++i) {
        std::vector<std::uint32_t>& to = of_tile_[routes_.steps[std::size_t(i)].tile];
        place_[std::size_t(i)] = std::uint32_t(to.size());
        to.push_back(ray);
      }
  }

  std::size_t n_rays() const { return routes_.n_rays(); }
  const std::vector<std::uint32_t>& of_tile(std::size_t tile) const { return of_tile_[tile]; }

  /// Call use(tile, j) for each tile on the route of a ray, which is the tile's j-th.
  template <class Use>
  void for_each_tile(std::size_t ray, Use&& use) const {
    for (std::int64_t i = routes_.offsets[ray]; i < routes_.offsets[ray + 1]; ++i)
      use(routes_.steps[std::size_t(i)].tile, place_[std::size_t(i)]);
  }

 private:
  RayRoutes routes_;
  LargeVector<std::uint32_t> place_;  // of each step: which one of the tile's rays it is
  std::vector<std::vector<std::uint32_t>> of_tile_;
};

/// Merges the lists of all tiles: all hits, or the best k.
class ListMerge {
 public:
  /// `lists`: of each tile that has rays.
  ListMerge(const TileRays& rays, std::span<const TileLists> lists, Keep keep, std::uint64_t k)
      : rays_(rays), lists_(lists), keep_(keep), k_(k) {}

  /// Where the hits of each ray begin, and where the last ones end.
  LargeVector<std::int64_t> offsets() const {
    LargeVector<std::int64_t> offsets(rays_.n_rays() + 1);
    for (std::size_t ray = 0; ray < rays_.n_rays(); ++ray) {
      std::uint64_t n = 0;
      rays_.for_each_tile(ray, [&](std::uint32_t tile, std::uint32_t j) {
        n += std::uint64_t(lists_[tile].offsets[j + 1] - lists_[tile].offsets[j]);
      });
      offsets[ray + 1] = offsets[ray] + std::int64_t(std::min(n, k_));
    }
    return offsets;
  }

  /// Write the hits of all rays.
  void write(std::span<const std::int64_t> offsets, const HitColumns& to, unsigned n_threads,
             Progress& progress) const {
    constexpr std::size_t rays_per_chunk = 1 << 10;
    parallel_for_chunks(
        rays_.n_rays(), rays_per_chunk, n_threads, progress, [] { return std::vector<Run>(); },
        [&](std::vector<Run>& runs, std::size_t begin, std::size_t end) {
          for (std::size_t ray = begin; ray < end; ++ray)
            merge(ray, runs, std::size_t(offsets[ray]), std::size_t(offsets[ray + 1]), to);
        });
  }

 private:
  /// What is left of the list of a tile, and its first hit.
  struct Run {
    const TileLists* of;
    std::size_t at, end;
    Hit first;

    void load() {
      if (at == end) return;
      first = of->hits[at];
      first.prim = of->ids(first.prim);
    }
  };

  /// Write the hits of a ray, [at, end) of all.
  void merge(std::size_t ray, std::vector<Run>& runs, std::size_t at, std::size_t end, const HitColumns& to) const {
    runs.clear();
    rays_.for_each_tile(ray, [&](std::uint32_t tile, std::uint32_t j) {
      const TileLists& of = lists_[tile];
      Run run{&of, std::size_t(of.offsets[j]), std::size_t(of.offsets[j + 1]), {}};
      run.load();
      if (run.at < run.end) runs.push_back(run);
    });
    while (at < end) {
      // Copy from the list with the best hit what precedes the best one of all others.
      std::size_t best = 0, next = ~std::size_t(0);
      for (std::size_t i = 1; i < runs.size(); ++i)
        if (comes_first(keep_, runs[i].first, runs[best].first)) {
          next = best;
          best = i;
        } else if (next == ~std::size_t(0) || comes_first(keep_, runs[i].first, runs[next].first)) {
          next = i;
        }
      Run& run = runs[best];
      do {
        to.set(at++, {run.first.t, run.first.prim, run.first.u, run.first.distance,
                      to.t_out ? run.of->hits.t_out[run.at] : kInfinity});
        ++run.at;
        run.load();
      } while (at < end && run.at < run.end &&
               (next == ~std::size_t(0) || comes_first(keep_, run.first, runs[next].first)));
      if (run.at == run.end) {
        run = runs.back();
        runs.pop_back();
      }
    }
  }

  const TileRays& rays_;
  std::span<const TileLists> lists_;
  Keep keep_;
  std::uint64_t k_;
};

}  // namespace fastlines
