// Parallel loops over chunks, which threads take from an atomic counter. If each chunk writes only its own results,
// they do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "progress.hpp"
#include "start_threads.hpp"

namespace fastlines {

/// The part of a long call's progress that a loop covers, as fractions of the whole.
struct Stage {
  double from = 0.0, to = 1.0;
};

/// Calls work(worker, chunk) for all chunks; make() creates the worker of each thread. The first exception stops the
/// loop and is rethrown.
template <class Make, class Work>
void parallel_for(std::size_t n_chunks, unsigned n_threads, Progress& progress, Make&& make, Work&& work,
                  Stage stage = {}) {
  std::atomic<std::size_t> next{0}, finished{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto run = [&] {
    try {
      auto worker = make();
      for (std::size_t chunk; (chunk = next.fetch_add(1)) < n_chunks;) {
        progress.check();
        work(worker, chunk);
        const double share = double(finished.fetch_add(1) + 1) / double(n_chunks);
        progress.done.store(stage.from + (stage.to - stage.from) * share, std::memory_order_relaxed);
      }
    } catch (...) {
      next.store(n_chunks);
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  };
  const std::size_t n_workers = std::min(std::size_t(n_threads), n_chunks);
  std::vector<std::thread> others = start_threads(n_workers > 1 ? n_workers - 1 : 0, [&run] { run(); });
  run();
  for (std::thread& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

/// Calls work(worker, begin, end) for chunks [begin, end) of [0, n): `chunk_size` indices each, fewer in the last one.
template <class Make, class Work>
void parallel_for_chunks(std::size_t n, std::size_t chunk_size, unsigned n_threads, Progress& progress, Make&& make,
                         Work&& work, Stage stage = {}) {
  parallel_for(
      (n + chunk_size - 1) / chunk_size, n_threads, progress, make,
      [&](auto& worker, std::size_t chunk) { work(worker, chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size)); },
      stage);
}

}  // namespace fastlines
