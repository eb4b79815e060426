// Parallel loops over chunks, which threads take from an atomic counter. If each chunk writes only its own results,
// they do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "../memory/function_ref.hpp"
#include "progress.hpp"
#include "start_threads.hpp"

namespace fastlines {

/// The part of a long call's progress that a loop covers, as fractions of the whole.
struct Stage {
  double from = 0.0, to = 1.0;
};

/// Hands the chunks of a loop to its threads. It is compiled once, whatever the threads do with their chunks.
class ChunkLoop {
 public:
  ChunkLoop(std::size_t n_chunks, Progress& progress, Stage stage)
      : n_chunks_(n_chunks), progress_(progress), stage_(stage) {}

  /// Call take_chunks() on each thread. The first exception stops the loop and is rethrown.
  void run(unsigned n_threads, FunctionRef<void()> take_chunks) {
    const auto guarded = [&] {
      try {
        take_chunks();
      } catch (...) {
        next_.store(n_chunks_);
        const std::lock_guard lock(mutex_);
        if (!error_) error_ = std::current_exception();
      }
    };
    const std::size_t n_workers = std::min(std::size_t(n_threads), n_chunks_);
    std::vector<std::thread> others = start_threads(n_workers > 1 ? n_workers - 1 : 0, [&guarded] { guarded(); });
    guarded();
    for (std::thread& thread : others) thread.join();
    if (error_) std::rethrow_exception(error_);
  }

  /// Take the next chunk, if there is one left.
  bool take(std::size_t& chunk) {
    chunk = next_.fetch_add(1);
    if (chunk >= n_chunks_) return false;
    progress_.check();
    return true;
  }

  /// Report that a chunk is finished.
  void finish() {
    const double share = double(finished_.fetch_add(1) + 1) / double(n_chunks_);
    progress_.done.store(stage_.from + (stage_.to - stage_.from) * share, std::memory_order_relaxed);
  }

 private:
  const std::size_t n_chunks_;
  Progress& progress_;
  const Stage stage_;
  std::atomic<std::size_t> next_{0}, finished_{0};
  std::exception_ptr error_;
  std::mutex mutex_;
};

/// Calls work(worker, chunk) for all chunks; make() creates the worker of each thread. The first exception stops the
/// loop and is rethrown.
template <class Make, class Work>
void parallel_for(std::size_t n_chunks, unsigned n_threads, Progress& progress, Make&& make, Work&& work,
                  Stage stage = {}) {
  ChunkLoop loop(n_chunks, progress, stage);
  loop.run(n_threads, [&] {
    auto worker = make();
    for (std::size_t chunk; loop.take(chunk); loop.finish()) work(worker, chunk);
  });
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
