// Runs a long call on a worker thread, while the calling thread watches it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "progress.hpp"

namespace fastlines {

/// Calls job(progress) on a worker thread, and poll(done) on this one every 50 ms, with the fraction that is done. Once
/// poll returns false, the job is cancelled. Returns what the job threw, or nullptr. `poll` must not throw. If the
/// system refuses a thread, this one does the job, unwatched.
template <class Job, class Poll>
std::exception_ptr run_watched(Job&& job, Poll&& poll) {
  Progress progress;
  std::exception_ptr error;
  const auto work = [&] {
    try {
      job(progress);
    } catch (...) {
      error = std::current_exception();
    }
  };
  bool finished = false;
  std::mutex mutex;
  std::condition_variable done;
  std::thread worker;
  try {
    worker = std::thread([&] {
      work();
      const std::lock_guard lock(mutex);
      finished = true;
      done.notify_one();
    });
  } catch (const std::system_error&) {
    work();
    return error;
  }
  std::unique_lock lock(mutex);
  double shown = 0.0;
  while (!done.wait_for(lock, kPollInterval, [&] { return finished; })) {
    if (progress.cancel.load()) continue;
    shown = shown_of(progress.done, shown);
    if (!poll(shown)) progress.cancel.store(true);
  }
  lock.unlock();
  worker.join();
  return error;
}

/// The same without a worker thread, for work that is mostly short: this thread does the job, and polls between its
/// parts if it takes long.
template <class Job, class Poll>
std::exception_ptr run_polling(Job&& job, Poll&& poll) {
  const FunctionRef<bool(double)> to_poll = poll;
  Progress progress(&to_poll);
  try {
    job(progress);
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace fastlines
