// Sums over lists of hits, which any search has found.
#pragma once

#include <numeric>
#include <vector>

#include "../../parallel/parallel_for.hpp"
#include "../../rays/ray_batch.hpp"
#include "hit_summer.hpp"

namespace fastlines {

/// Hits of all rays as columns; those of ray i are from offsets[i] up to offsets[i + 1].
struct ListedHits {
  std::span<const std::int64_t> offsets, prim;
  std::span<const float> t, u, distance;
};

/// Write the sums of all rays. `lines` has a row for each hit.
inline void gather_lists(const GatherRule& rule, const RayBatch& rays, const ListedHits& hits, const GatherLines& lines,
                         const GatherSums& to, unsigned n_threads, Progress& progress) {
  struct Worker {
    HitSummer summer;
    std::vector<std::uint32_t> prim, line;
  };
  constexpr std::size_t rays_at_once = 256;
  parallel_for_chunks(
      rays.size(), rays_at_once, n_threads, progress, [&] { return Worker{HitSummer(rule), {}, {}}; },
      [&](Worker& worker, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          progress.check();
          const auto first = std::size_t(hits.offsets[i]), n = std::size_t(hits.offsets[i + 1]) - first;
          worker.prim.assign(hits.prim.data() + first, hits.prim.data() + first + n);
          worker.line.resize(n);
          std::iota(worker.line.begin(), worker.line.end(), 0u);
          const GatherLines of_ray{lines.rows + first * lines.n_numbers, lines.n_numbers};
          const GatherHits found{hits.t.data() + first, hits.u.data() + first, hits.distance.data() + first,
                                 worker.prim.data(),    worker.line.data(),    n};
          worker.summer.sum(GatherRay(rays[i], i, rule), of_ray, found, to.of_ray(i));
        }
      });
}

}  // namespace fastlines
