// Batches of rays on all cores. Rays are dealt out in chunks by a counter; each answer has its own place, so the number
// of threads can not be seen in it.
#pragma once

#include "../threads/chunks.hpp"
#include "search.hpp"

namespace fastlines {

/// Rays as arrays. Radius and bounds have one entry a ray, or one for all.
struct RayBatch {
  std::span<const Vec3> origins, directions;
  std::span<const float> radius, t_min, t_max;

  std::size_t size() const { return origins.size(); }

  RayQuery operator[](std::size_t i) const {
    return {origins[i], directions[i], pick(t_min, i), pick(t_max, i), pick(radius, i)};
  }

  /// Ask for the memory of these rays before it is needed. To ask but once for those that share a line is slower.
  void fetch(const std::uint32_t* ids, int n) const {
    for (int i = 0; i < n; ++i) {
      __builtin_prefetch(&origins[ids[i]]);
      __builtin_prefetch(&directions[ids[i]]);
    }
  }

  static float pick(std::span<const float> values, std::size_t i) { return values[values.size() == 1 ? 0 : i]; }
};

inline constexpr std::size_t kChunk = 256;

/// Search for every ray, in chunks: make(ray) gives its sink, and store(i, sink) takes what that has found.
template <class Search, class Make, class Store>
void for_each_ray(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress, Make&& make,
                  Store&& store) {
  using Scratch = typename Search::Scratch;
  for_each_chunk((rays.size() + kChunk - 1) / kChunk, n_threads, progress, [] { return Scratch{}; },
                 [&](Scratch& scratch, std::size_t chunk) {
                   for (std::size_t i = chunk * kChunk; i < std::min(rays.size(), (chunk + 1) * kChunk); ++i) {
                     progress.check();
                     const Ray ray = prepare(rays[i], search.frame);
                     auto sink = make(ray);
                     search(ray, sink, scratch);
                     store(i, sink);
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

template <class Search>
void any_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
              std::span<bool> found) {
  for_each_ray(
      search, rays, n_threads, progress, [](const Ray& ray) { return AnySink(ray); },
      [&](std::size_t i, const AnySink& sink) { found[i] = sink.found; });
}

template <class Search>
void count_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
                std::span<std::int64_t> counts) {
  for_each_ray(
      search, rays, n_threads, progress, [](const Ray& ray) { return CountSink(ray); },
      [&](std::size_t i, const CountSink& sink) { counts[i] = sink.n_hits; });
}

}  // namespace fastlines
