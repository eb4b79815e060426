// Runs a scalar search for every ray of a batch, in parallel. Each ray has its own answer, so answers do not depend on
// the number of threads.
#pragma once

#include "../parallel/parallel_for.hpp"
#include "../rays/ray_batch.hpp"
#include "hit_assembler.hpp"
#include "sinks.hpp"

namespace fastlines {

/// Search for one ray; returns the sink that make(ray) has made, with its hits.
template <class Search, class Make>
auto search_ray(const Search& search, const RayQuery& query, typename Search::Scratch& scratch, Make&& make) {
  using P = std::remove_cvref_t<decltype(search.prims)>;
  const auto ray = prepare_for<P>(query, search.frame);
  auto sink = make(ray);
  SinkRef<P> to(sink);
  search(ray, to, scratch);
  return sink;
}

/// Rays that a thread takes at a time.
inline constexpr std::size_t kRaysPerChunk = 256;

/// Search for every ray. make(ray) returns the ray's sink; store(i, sink) stores its result.
template <class Search, class Make, class Store>
void for_each_ray(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress, Make&& make,
                  Store&& store) {
  using Scratch = typename Search::Scratch;
  parallel_for_chunks(
      rays.size(), kRaysPerChunk, n_threads, progress, [] { return Scratch{}; },
      [&](Scratch& scratch, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          progress.check();
          store(i, search_ray(search, rays[i], scratch, make));
        }
      });
}

/// Call store(i, hit) with the nearest hit of every ray.
template <class Search, class Store>
void first_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress,
                Store&& store) {
  for_each_ray(
      search, rays, n_threads, progress, [at](const Ray& ray) { return FirstSink(at, ray); },
      [&](std::size_t i, const FirstSink& sink) { store(i, sink.best); });
}

/// Write whether each ray hits anything.
template <class Search>
void any_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
              std::span<bool> found) {
  for_each_ray(
      search, rays, n_threads, progress, [](const Ray& ray) { return AnySink(ray); },
      [&](std::size_t i, const AnySink& sink) { found[i] = sink.found; });
}

/// Write how many primitives each ray hits.
template <class Search>
void count_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
                std::span<std::int64_t> counts) {
  for_each_ray(
      search, rays, n_threads, progress, [](const Ray& ray) { return CountSink(ray); },
      [&](std::size_t i, const CountSink& sink) { counts[i] = sink.n_hits; });
}

/// Assemble the lists of hits of the sinks that make(ray) returns, sorted by t; or of each ray the `n_nearest` hits
/// that are nearest to it, in order of their distance.
template <class Search, class Make>
void list_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress, HitAssembler& to,
               Make&& make, std::optional<std::size_t> n_nearest = {}) {
  struct Worker {
    typename Search::Scratch scratch;
    HitBuffer lists;
  };
  const std::size_t n_chunks = (rays.size() + kRaysPerChunk - 1) / kRaysPerChunk;
  parallel_for(
      n_chunks, n_threads, progress, [] { return Worker{}; },
      [&](Worker& worker, std::size_t i_chunk) {
        const std::size_t chunk = HitAssembler::sample_first(i_chunk, n_chunks);
        const std::size_t end = std::min(rays.size(), (chunk + 1) * kRaysPerChunk);
        for (std::size_t i = chunk * kRaysPerChunk; i < end; ++i) {
          progress.check();
          auto sink = search_ray(search, rays[i], worker.scratch, make);
          worker.lists.add(std::uint32_t(i), sink.hits, n_nearest);
        }
        to.add(chunk, n_chunks, end, worker.lists);
      });
}

}  // namespace fastlines
