// Runs long calls with a callback for their progress.
#pragma once

#include <algorithm>

#include "fastlines/api/tree.hpp"
#include "fastlines/parallel/run_watched.hpp"

namespace fl::detail {

/// One thread for each core by default, and never more than 1,024.
inline unsigned n_threads_of(unsigned wanted) {
  return std::clamp(wanted ? wanted : std::thread::hardware_concurrency(), 1u, 1024u);
}

/// Calls job(progress). With a callback, a worker thread does the job, and this thread calls back every 50 ms. If the
/// callback returns false or throws, the job is cancelled.
template <class Job>
void watch(const Progress& callback, Job&& job) {
  if (!callback) {
    fastlines::Progress progress;
    return job(progress);
  }
  std::exception_ptr from_callback;
  const std::exception_ptr error = fastlines::run_watched(job, [&](double done) {
    try {
      return callback(done);
    } catch (...) {
      from_callback = std::current_exception();
      return false;
    }
  });
  if (from_callback) std::rethrow_exception(from_callback);
  if (!error) return;
  try {
    std::rethrow_exception(error);
  } catch (const fastlines::Cancelled&) {
    throw Cancelled("cancelled by the progress callback");
  }
}

}  // namespace fl::detail
