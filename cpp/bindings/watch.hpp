// Long calls: the work runs on a thread of its own without the GIL, while the calling thread polls it, reports progress
// to Python, and stops it on Ctrl-C or when the progress callback raises.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "fastlines/parallel/progress.hpp"
#include "gil.hpp"

namespace fastlines {

template <class Job>
void watch(Job&& job, nanobind::object callback) {
  Progress progress;
  std::exception_ptr error;
  bool finished = false;
  std::mutex mutex;
  std::condition_variable done;
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
    // The system gives no thread: do the work here, unwatched.
    const WithoutGil without_gil;
    return job(progress);
  }
  {
    WithoutGil without_gil;
    std::unique_lock lock(mutex);
    double shown = 0.0;
    const auto look_in = [&] {
      bool stop = PyErr_CheckSignals() != 0;
      if (!stop && !callback.is_none()) {
        // Threads report their shares in any order, and rounding may bring their sum past one.
        shown = std::clamp(progress.done.load(), shown, 1.0);
        PyObject* result = PyObject_CallFunction(callback.ptr(), "d", shown);
        stop = result == nullptr;
        Py_XDECREF(result);
      }
      if (stop) progress.cancel.store(true);
    };
    while (!done.wait_for(lock, std::chrono::milliseconds(50), [&] { return finished; }))
      if (!progress.cancel.load()) without_gil.with_gil(look_in);
    lock.unlock();
    worker.join();
  }
  if (PyErr_Occurred()) throw nanobind::python_error();
  if (error) std::rethrow_exception(error);
}

/// Whether a call may take long enough for Ctrl-C: many rays, or many primitives for each.
inline bool may_be_long(std::size_t n_rays, std::size_t n_things) {
  return n_rays > 256 || n_rays * n_things > 10'000'000;
}

/// Short work runs at once on the calling thread.
template <class Job>
void watch_if(bool is_long, const nanobind::object& callback, Job&& job) {
  if (is_long) return watch(job, callback);
  const WithoutGil without_gil;
  Progress unwatched;
  job(unwatched);
}

}  // namespace fastlines
