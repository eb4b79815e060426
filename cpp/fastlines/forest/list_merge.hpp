// Merges the lists of hits that tiles have found into one list for each ray.
#pragma once

#include <vector>

#include "../query/ray_collectors.hpp"
#include "best_hits.hpp"
#include "tile_walk.hpp"

namespace fastlines {

/// The lists of a tile: those of its j-th ray are from offsets[j] up to offsets[j + 1], in the order that `Keep` gives.
/// Hits have the numbers of the forest.
struct TileLists {
  std::span<const std::int64_t> offsets;
  HitColumns hits;
};

/// The rays that each tile is queried with: all whose routes lead there.
class TileRays {
 public:
  TileRays(RayRoutes routes, const RayBatch& rays)
      : routes_(std::move(routes)), place_(routes_.steps.size()), of_tile_(routes_.n_tiles) {
    std::vector<std::size_t> n(n_tiles());
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
  std::size_t n_tiles() const { return routes_.n_tiles; }
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
  LargeVector<std::int64_t> offsets(unsigned n_threads) const {
    LargeVector<std::int64_t> offsets(rays_.n_rays() + 1);
    Progress unwatched;
    parallel_for_chunks(
        rays_.n_rays(), kRaysPerChunk, n_threads, unwatched, [] { return 0; },
        [&](int, std::size_t begin, std::size_t end) {
          for (std::size_t ray = begin; ray < end; ++ray) {
            std::uint64_t n = 0;
            rays_.for_each_tile(ray, [&](std::uint32_t tile, std::uint32_t j) {
              n += std::uint64_t(lists_[tile].offsets[j + 1] - lists_[tile].offsets[j]);
            });
            offsets[ray + 1] = std::int64_t(std::min(n, k_));
          }
        });
    for (std::size_t ray = 0; ray < rays_.n_rays(); ++ray) offsets[ray + 1] += offsets[ray];
    return offsets;
  }

  /// Write the hits of all rays.
  void write(std::span<const std::int64_t> offsets, const HitColumns& to, unsigned n_threads,
             Progress& progress) const {
    parallel_for_chunks(
        rays_.n_rays(), kRaysPerChunk, n_threads, progress, [] { return std::vector<Run>(); },
        [&](std::vector<Run>& runs, std::size_t begin, std::size_t end) {
          for (std::size_t ray = begin; ray < end; ++ray)
            if (offsets[ray] < offsets[ray + 1])
              merge(ray, runs, std::size_t(offsets[ray]), std::size_t(offsets[ray + 1]), to);
        });
  }

 private:
  static constexpr std::size_t kRaysPerChunk = 1 << 12;

  /// What is left of the list of a tile, which is not empty, and its first hit.
  struct Run {
    const TileLists* of;
    std::size_t at, end;
    Hit first;

    /// Hit i of the list, without its t_out.
    Hit hit(std::size_t i) const { return of->hits[i]; }
  };

  /// Write the hits of a ray, [at, end) of all.
  void merge(std::size_t ray, std::vector<Run>& runs, std::size_t at, std::size_t end, const HitColumns& to) const {
    runs.clear();
    bool in_order = true;
    rays_.for_each_tile(ray, [&](std::uint32_t tile, std::uint32_t j) {
      const TileLists& of = lists_[tile];
      Run run{&of, std::size_t(of.offsets[j]), std::size_t(of.offsets[j + 1]), {}};
      if (run.at == run.end) return;
      run.first = run.hit(run.at);
      in_order = in_order && (runs.empty() || comes_first(keep_, runs.back().hit(runs.back().end - 1), run.first));
      runs.push_back(run);
    });
    // Mostly a ray leaves a tile before it enters the next one.
    if (in_order) {
      for (const Run& run : runs) at += copy(run, std::min(run.end - run.at, end - at), to, at);
      return;
    }
    while (at < end) {
      // Copy from the list with the best hit what precedes the best one of all others.
      const Run* next = nullptr;
      std::size_t best = 0;
      for (std::size_t i = 1; i < runs.size(); ++i)
        if (comes_first(keep_, runs[i].first, runs[best].first)) {
          next = &runs[best];
          best = i;
        } else if (!next || comes_first(keep_, runs[i].first, next->first)) {
          next = &runs[i];
        }
      Run& run = runs[best];
      std::size_t n = 1;
      for (const std::size_t most = std::min(run.end - run.at, end - at); n < most; ++n)
        if (next && !comes_first(keep_, run.hit(run.at + n), next->first)) break;
      at += copy(run, n, to, at);
      run.at += n;
      if (run.at < run.end) {
        run.first = run.hit(run.at);
      } else {
        run = runs.back();
        runs.pop_back();
      }
    }
  }

  /// Copy the first n hits of a list, and return n.
  static std::size_t copy(const Run& run, std::size_t n, const HitColumns& to, std::size_t at) {
    const HitColumns& from = run.of->hits;
    for (std::size_t i = 0; i < n; ++i) {
      to.t[at + i] = from.t[run.at + i];
      to.prim[at + i] = from.prim[run.at + i];
      to.u[at + i] = from.u[run.at + i];
      to.distance[at + i] = from.distance[run.at + i];
    }
    if (to.t_out) std::copy_n(from.t_out + run.at, n, to.t_out + at);
    return n;
  }

  const TileRays& rays_;
  std::span<const TileLists> lists_;
  Keep keep_;
  std::uint64_t k_;
};

}  // namespace fastlines
