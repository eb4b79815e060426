// Runs long calls on a worker thread without the GIL. The calling thread polls the worker, reports progress to Python,
// and stops the worker on Ctrl-C or when the progress callback raises.
#pragma once

#include <nanobind/nanobind.h>

#include "fastlines/parallel/run_watched.hpp"
#include "gil.hpp"

namespace fastlines {

/// Calls job(progress) on a worker thread. `callback` is None or takes the fraction done, every 50 ms.
template <class Job>
void watch(Job&& job, nanobind::object callback) {
  std::exception_ptr error;
  {
    WithoutGil without_gil;
    error = run_watched(job, [&](double done) {
      bool stop = false;
      without_gil.with_gil([&] {
        stop = PyErr_CheckSignals() != 0;
        if (stop || callback.is_none()) return;
        PyObject* result = PyObject_CallFunction(callback.ptr(), "d", done);
        stop = result == nullptr;
        Py_XDECREF(result);
      });
      return !stop;
    });
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
