// Batches of rays on all cores. Rays are dealt out in chunks by a counter; each answer has its own place, so the number
// of threads can not be seen in it.
#pragma once

#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "../build/progress.hpp"
#include "search.hpp"

namespace fastlines {

/// Rays as arrays. Radius and bounds have one entry a ray, or one for all.
struct RayBatch {
  std::span<const Vec3> origins, directions;
  std::span<const float> radius, t_min, t_max;

  std::size_t size() const { return origins.size(); }

  RayQuery operator[](std::size_t i) const {
    const auto pick = [i](std::span<const float> values) { return values.size() == 1 ? values[0] : values[i]; };
    return {origins[i], directions[i], pick(t_min), pick(t_max), pick(radius)};
  }
};

inline constexpr std::size_t kChunk = 256;

/// Call work(chunk, begin, end, scratch) for all chunks of n rays. The first exception ends the batch and is rethrown.
template <class Work>
void for_each_chunk(std::size_t n, unsigned n_threads, Progress& progress, Work&& work) {
  const std::size_t n_chunks = (n + kChunk - 1) / kChunk;
  std::atomic<std::size_t> next{0}, finished{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto run = [&] {
    Scratch scratch;
    try {
      for (std::size_t chunk; (chunk = next.fetch_add(1)) < n_chunks;) {
        progress.check();
        work(chunk, chunk * kChunk, std::min(n, (chunk + 1) * kChunk), scratch);
        progress.done.store(double(finished.fetch_add(1) + 1) / double(n_chunks), std::memory_order_relaxed);
      }
    } catch (...) {
      next.store(n_chunks);
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  try {
    for (std::size_t i = 1; i < std::min(std::size_t(n_threads), n_chunks); ++i) threads.emplace_back(run);
  } catch (const std::system_error&) {
    // The system gives no more threads: those that there are do the work.
  }
  run();
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

/// Call answer(i, ray, scratch) for every ray.
template <class Answer>
void for_each_ray(const RayBatch& rays, const Frame& frame, unsigned n_threads, Progress& progress, Answer&& answer) {
  for_each_chunk(rays.size(), n_threads, progress,
                 [&](std::size_t, std::size_t begin, std::size_t end, Scratch& scratch) {
                   for (std::size_t i = begin; i < end; ++i) {
                     progress.check();
                     answer(i, prepare(rays[i], frame), scratch);
                   }
                 });
}

/// Call store(i, hit) with the nearest hit of every ray.
template <class Search, class Store>
void first_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress,
                Store&& store) {
  for_each_ray(rays, search.frame, n_threads, progress, [&](std::size_t i, const Ray& ray, Scratch& scratch) {
    FirstSink sink(at, ray);
    search(ray, sink, scratch);
    store(i, sink.best);
  });
}

template <class Search>
void any_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
              std::span<bool> found) {
  for_each_ray(rays, search.frame, n_threads, progress, [&](std::size_t i, const Ray& ray, Scratch& scratch) {
    AnySink sink(ray);
    search(ray, sink, scratch);
    found[i] = sink.found;
  });
}

template <class Search>
void count_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
                std::span<std::int64_t> counts) {
  for_each_ray(rays, search.frame, n_threads, progress, [&](std::size_t i, const Ray& ray, Scratch& scratch) {
    CountSink sink(ray);
    search(ray, sink, scratch);
    counts[i] = sink.n_hits;
  });
}

/// All hits as CSR: those of ray i are hits[offsets[i] … offsets[i + 1]), sorted by (t, prim).
struct AllHits {
  std::vector<std::int64_t> offsets;
  std::vector<std::vector<Hit>> chunks;  // one after the other they are the hits
};

template <class Search>
AllHits all_hits(const Search& search, const RayBatch& rays, At at, unsigned n_threads, Progress& progress) {
  AllHits all;
  all.offsets.assign(rays.size() + 1, 0);
  all.chunks.resize((rays.size() + kChunk - 1) / kChunk);
  for_each_chunk(rays.size(), n_threads, progress,
                 [&](std::size_t chunk, std::size_t begin, std::size_t end, Scratch& scratch) {
                   std::vector<Hit> hits;
                   for (std::size_t i = begin; i < end; ++i) {
                     progress.check();
                     const auto n_before = std::ptrdiff_t(hits.size());
                     const Ray ray = prepare(rays[i], search.frame);
                     AllSink sink(at, ray, hits);
                     search(ray, sink, scratch);
                     std::sort(hits.begin() + n_before, hits.end());
                     all.offsets[i + 1] = std::int64_t(hits.size()) - n_before;
                   }
                   hits.shrink_to_fit();
                   all.chunks[chunk] = std::move(hits);
                 });
  for (std::size_t i = 0; i < rays.size(); ++i) all.offsets[i + 1] += all.offsets[i];
  return all;
}

}  // namespace fastlines
