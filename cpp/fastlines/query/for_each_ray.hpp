// Runs a scalar search for every ray of a batch, in parallel. Each ray has its own answer, so answers do not depend on
// the number of threads.
#pragma once

#include "../parallel/parallel_for.hpp"
#include "../rays/ray_batch.hpp"
#include "hit_assembler.hpp"
#include "hit_vector.hpp"
#include "test_primitive.hpp"

namespace fastlines {

/// Report the hits of a ray to the collector.
template <class Search, class Ray, RayCollector C>
void search_ray(const Search& search, const Ray& ray, typename Search::Scratch& scratch, C& to) {
  RayCollectorRef any(to);
  search(ray, any, scratch);
}

/// Where a ray leaves a primitive that a search has found.
template <class Search, class Ray>
float exit_of(const Search& search, const Ray& ray, std::int64_t prim) {
  return exit_of(search.prims, ray, search.frame, std::uint32_t(prim));
}

/// Rays that a thread takes at a time.
inline constexpr std::size_t kRaysPerChunk = 256;

/// The prepared rays of a search.
template <class Search>
using RayOfSearch = RayOf<std::remove_cvref_t<decltype(std::declval<Search>().prims)>>;

/// Call answer(i, ray, scratch) for every ray, prepared for the search. Compiled once for all queries.
template <class Search>
void for_each_ray(
    const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
    std::type_identity_t<FunctionRef<void(std::size_t, const RayOfSearch<Search>&, typename Search::Scratch&)>>
        answer) {
  using P = std::remove_cvref_t<decltype(search.prims)>;
  struct Worker {
    Checkpoint checkpoint;
    typename Search::Scratch scratch;
  };
  parallel_for_chunks(
      rays.size(), kRaysPerChunk, n_threads, progress, [&] { return Worker{Checkpoint(progress), {}}; },
      [&](Worker& worker, std::size_t begin, std::size_t end) {
        worker.scratch.checkpoint = &worker.checkpoint;
        for (std::size_t i = begin; i < end; ++i) {
          worker.checkpoint.pass();
          answer(i, prepare_for<P>(rays[i], search.frame), worker.scratch);
        }
      });
}

/// Call store(i, hit) with the first hit of every ray.
template <class Search, class Store>
void first_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress,
                Store&& store) {
  for_each_ray(search, rays, n_threads, progress, [&](std::size_t i, const auto& ray, auto& scratch) {
    FirstHitOfRay<ChosenAt> first(ray, {at});
    search_ray(search, ray, scratch, first);
    Hit hit = first.hit();
    if (has_exit(at) && first.found()) hit.t_out = exit_of(search, ray, hit.prim);
    store(i, hit);
  });
}

/// Write whether each ray hits anything.
template <class Search>
void any_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress,
              std::span<bool> found) {
  for_each_ray(search, rays, n_threads, progress, [&](std::size_t i, const auto& ray, auto& scratch) {
    AnyHitOfRay<ChosenAt> any(ray, {at});
    search_ray(search, ray, scratch, any);
    found[i] = any.found;
  });
}

/// Write how many primitives each ray hits.
template <class Search>
void count_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress,
                std::span<std::int64_t> counts) {
  for_each_ray(search, rays, n_threads, progress, [&](std::size_t i, const auto& ray, auto& scratch) {
    HitCountOfRay<ChosenAt> count(ray, ~0ull, {at});
    search_ray(search, ray, scratch, count);
    counts[i] = std::int64_t(count.n);
  });
}

/// Assemble the lists of hits of all rays: all hits of each by t, its first k by t, or the k nearest to it by distance.
template <class Search>
void list_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress, HitAssembler& to,
               At at, Keep keep = Keep::all, std::uint64_t k = ~0ull) {
  using P = std::remove_cvref_t<decltype(search.prims)>;
  struct Worker {
    Checkpoint checkpoint;
    typename Search::Scratch scratch;
    std::vector<Hit> hits;
    HitBuffer lists;
  };
  const std::size_t n_chunks = (rays.size() + kRaysPerChunk - 1) / kRaysPerChunk;
  to.progress = &progress;
  parallel_for(
      n_chunks, n_threads, progress, [&] { return Worker{Checkpoint(progress), {}, {}, {}}; },
      [&](Worker& worker, std::size_t i_chunk) {
        worker.scratch.checkpoint = &worker.checkpoint;
        const std::size_t chunk = HitAssembler::sample_first(i_chunk, n_chunks);
        const std::size_t end = std::min(rays.size(), (chunk + 1) * kRaysPerChunk);
        for (std::size_t i = chunk * kRaysPerChunk; i < end; ++i) {
          worker.checkpoint.pass();
          const auto ray = prepare_for<P>(rays[i], search.frame);
          HitVectorOfRay<Hit> list(ray, at, keep, worker.hits, k);
          search_ray(search, ray, worker.scratch, list);
          list.finish();
          worker.checkpoint.check();
          if (has_exit(at))
            for (Hit& hit : worker.hits) hit.t_out = exit_of(search, ray, hit.prim);
          worker.lists.add(std::uint32_t(i), worker.hits);
        }
        to.add(chunk, n_chunks, end, worker.lists);
      });
}

}  // namespace fastlines
