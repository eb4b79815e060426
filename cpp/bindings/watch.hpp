// Runs long calls on a worker thread without the GIL. The calling thread polls the worker, reports progress to Python,
// and stops the worker on Ctrl-C or when the progress callback raises. Short calls run on the calling thread, which
// polls by itself if they take long.
#pragma once

#include <nanobind/nanobind.h>

#include "fastlines/parallel/run_watched.hpp"
#include "gil.hpp"

namespace fastlines {

/// Calls job(progress), on a worker thread if it is long. `callback` is None or takes the fraction done, every 50 ms.
template <class Job>
void watch_if(bool is_long, const nanobind::object& callback, Job&& job) {
  std::exception_ptr error;
  {
    WithoutGil without_gil;
    const auto poll = [&](double done) {
      bool stop = false;
      without_gil.with_gil([&] {
        stop = PyErr_CheckSignals() != 0;
        if (stop || callback.is_none()) return;
        PyObject* result = PyObject_CallFunction(callback.ptr(), "d", done);
        stop = result == nullptr;
        Py_XDECREF(result);
      });
      return !stop;
    };
    error = is_long ? run_watched(job, poll) : run_polling(job, poll);
  }
  if (PyErr_Occurred()) throw nanobind::python_error();
  if (error) std::rethrow_exception(error);
}

/// Calls job(progress) on a worker thread.
template <class Job>
void watch(Job&& job, const nanobind::object& callback) {
  watch_if(true, callback, job);
}

}  // namespace fastlines
