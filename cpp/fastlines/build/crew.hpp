// Threads that work together.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace fastlines {

/// What threads wait at until it is known how many of them work.
struct Gate {
  static constexpr auto kUnknown = std::numeric_limits<std::size_t>::max();
  std::atomic<std::size_t> n_kept{kUnknown};
  std::mutex mutex;
};

/// Up to n threads that call run, once all of them are there. Where the system refuses one, the memory may be used up
/// by the stacks of those that there are: half of them are let go, for the work needs memory too. Whoever called goes
/// on with fewer, or alone.
template <class Run>
std::vector<std::thread> start_crew(std::size_t n, Run run) {
  const auto gate = std::make_shared<Gate>();
  // A thread's first exception and first thread-local variable need memory, and glibc ends the process if there is
  // none: each thread takes it before it works, one after another, since the first allocation of a thread borrows 128
  // MB of addresses for a moment.
  const auto take_memory = [] {
    [[maybe_unused]] thread_local volatile bool taken;
    taken = std::uncaught_exceptions() == 0;
  };

  take_memory();
  std::unique_lock closed(gate->mutex);
  std::vector<std::thread> crew;
  crew.reserve(n);
  std::size_t n_kept = n;
  try {
    for (std::size_t i = 0; i < n; ++i)
      crew.emplace_back([=] {
        gate->n_kept.wait(Gate::kUnknown);
        if (i >= gate->n_kept) return;
        std::unique_lock one_by_one(gate->mutex);
        take_memory();
        one_by_one.unlock();
        run();
      });
  } catch (const std::exception&) {
    n_kept = crew.size() / 2;
  }
  gate->n_kept = n_kept;
  gate->n_kept.notify_all();
  for (; crew.size() > n_kept; crew.pop_back()) crew.back().join();
  return crew;
}

}  // namespace fastlines
