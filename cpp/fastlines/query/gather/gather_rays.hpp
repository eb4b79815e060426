// Sums over all hits of rays that a scalar search finds, one ray after the other.
#pragma once

#include "../for_each_ray.hpp"
#include "hit_summer.hpp"

namespace fastlines {

/// Write the sums of all rays.
template <class Search>
void gather_rays(const Search& search, const RayBatch& rays, const GatherRule& rule, const GatherLines& lines,
                 unsigned n_threads, Progress& progress, const GatherSums& to) {
  using P = std::remove_cvref_t<decltype(search.prims)>;
  struct Worker {
    HitSummer summer;
    Checkpoint checkpoint;
    typename Search::Scratch scratch;
    std::vector<Hit> hits;
  };
  parallel_for_chunks(
      rays.size(), kRaysPerChunk, n_threads, progress,
      [&] { return Worker{HitSummer(rule), Checkpoint(progress), {}, {}}; },
      [&](Worker& worker, std::size_t begin, std::size_t end) {
        worker.scratch.checkpoint = &worker.checkpoint;
        for (std::size_t i = begin; i < end; ++i) {
          worker.checkpoint.pass();
          const auto ray = prepare_for<P>(rays[i], search.frame);
          HitVectorOfRay<Hit> list(ray, At::closest, Keep::all, worker.hits, ~0ull);
          search_ray(search, ray, worker.scratch, list);
          list.finish();
          worker.summer.sum(GatherRay(rays[i], i, rule), lines, std::span<const Hit>(worker.hits), to.of_ray(i));
        }
      });
}

}  // namespace fastlines
