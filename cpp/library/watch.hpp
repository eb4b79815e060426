// Runs long calls with a callback for their progress.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <thread>

#include "fastlines/api/tree.hpp"
#include "fastlines/parallel/progress.hpp"

namespace fl::detail {

/// One thread for each core by default, and never more than 1,024.
inline unsigned n_threads_of(unsigned wanted) {
  return std::clamp(wanted ? wanted : std::thread::hardware_concurrency(), 1u, 1024u);
}

/// Calls job(progress). With a callback, a worker thread does the job, and this thread calls back every 50 ms. If the
/// callback returns false or throws, the job is cancelled.
template <class Job>
void watch(const Progress& callback, Job&& job) {
  fastlines::Progress progress;
  if (!callback) return job(progress);
  std::mutex mutex;
  std::condition_variable done;
  bool finished = false;
  std::exception_ptr error, from_callback;
  std::thread worker;
  try {
    worker = std::thread([&] {
      try {
        job(progress);
      } catch (...) {
        error = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      finished = true;
      done.notify_one();
    });
  } catch (const std::system_error&) {
    return job(progress);  // the system refuses a thread: do the work here, unwatched
  }
  double shown = 0.0;
  std::unique_lock lock(mutex);
  while (!done.wait_for(lock, std::chrono::milliseconds(50), [&] { return finished; })) {
    if (progress.cancel.load()) continue;
    lock.unlock();
    // Threads report their shares in any order.
    shown = std::clamp(progress.done.load(), shown, 1.0);
    try {
      if (!callback(shown)) progress.cancel.store(true);
    } catch (...) {
      from_callback = std::current_exception();
      progress.cancel.store(true);
    }
    lock.lock();
  }
  lock.unlock();
  worker.join();
  if (from_callback) std::rethrow_exception(from_callback);
  if (!error) return;
  try {
    std::rethrow_exception(error);
  } catch (const fastlines::Cancelled&) {
    throw Cancelled("cancelled by the progress callback");
  }
}

}  // namespace fl::detail
