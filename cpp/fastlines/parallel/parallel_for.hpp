// Work on all cores: chunks of it are dealt out by a counter. Where each chunk has a place of its own for what it
// finds, the number of threads can not be seen in the outcome.
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "progress.hpp"
#include "thread_pool.hpp"

namespace fastlines {

/// Which part of a long call's progress some work is.
struct Stage {
  double from = 0.0, to = 1.0;
};

/// Call work(worker, chunk) for all chunks, each thread with a worker that make() gave it. The first exception ends the
/// work and is rethrown.
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
