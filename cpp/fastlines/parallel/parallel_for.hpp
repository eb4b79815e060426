// A parallel loop over chunks, which threads take from an atomic counter. If each chunk writes to a place of its own,
// the result does not depend on the number of threads.
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "progress.hpp"
#include "thread_pool.hpp"

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

}  // namespace fastlines
