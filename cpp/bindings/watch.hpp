// Runs long calls on a worker thread without the GIL. The calling thread polls the worker, reports progress to Python,
// and stops the worker on Ctrl-C or when the progress callback raises.
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

/// Calls job(progress) on a worker thread. `callback` is None or takes the fraction done, every 50 ms.
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
    // The system refuses a thread: do the work here, unwatched.
    const WithoutGil without_gil;
    return job(progress);
  }
  {
    WithoutGil without_gil;
    std::unique_lock lock(mutex);
    double shown = 0.0;
    const auto poll = [&] {
      bool stop = PyErr_CheckSignals() != 0;
      if (!stop && !callback.is_none()) {
        // Threads report their shares in any order, and rounding may raise their sum above 1.
        shown = std::clamp(progress.done.load(), shown, 1.0);
        PyObject* result = PyObject_CallFunction(callback.ptr(), "d", shown);
        stop = result == nullptr;
        Py_XDECREF(result);
      }
      if (stop) progress.cancel.store(true);
    };
    while (!done.wait_for(lock, std::chrono::milliseconds(50), [&] { return finished; }))
      if (!progress.cancel.load()) without_gil.with_gil(poll);
    lock.unlock();
    worker.join();
  }
  if (PyErr_Occurred()) throw nanobind::python_error();
  if (error) std::rethrow_exception(error);
}

/// Calls job(progress), watched if it is long; short work runs on the calling thread.
template <class Job>
void watch_if(bool is_long, const nanobind::object& callback, Job&& job) {
  if (is_long) return watch(job, callback);
  const WithoutGil without_gil;
  Progress unwatched;
  job(unwatched);
}

}  // namespace fastlines
