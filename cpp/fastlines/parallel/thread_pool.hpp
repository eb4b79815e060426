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

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#endif

namespace fastlines {

/// Let a thread that has just been started run on another core than this one, which has work to do: the system may put
/// it here all the same, to wait for milliseconds until it looks whether other cores are idle. From then on it may run
/// anywhere. These are hints: if they are refused, it begins where it was put.
inline void move_off_this_core([[maybe_unused]] std::thread& thread) {
#ifdef __linux__
  const int here = sched_getcpu();
  cpu_set_t anywhere;
  if (here < 0 || here >= CPU_SETSIZE || pthread_getaffinity_np(pthread_self(), sizeof anywhere, &anywhere) != 0)
    return;
  cpu_set_t elsewhere = anywhere;
  CPU_CLR(here, &elsewhere);
  if (CPU_COUNT(&elsewhere) == 0) return;
  pthread_setaffinity_np(thread.native_handle(), sizeof elsewhere, &elsewhere);
  pthread_setaffinity_np(thread.native_handle(), sizeof anywhere, &anywhere);
#endif
}

/// What threads wait at until it is known how many of them work.
struct StartGate {
  static constexpr auto kUnknown = std::numeric_limits<std::size_t>::max();
  std::atomic<std::size_t> n_kept{kUnknown}, n_missing{0};
  std::mutex mutex;
};

/// Up to n threads that call run, once all of them are there. Where the system refuses one, the memory may be used up
/// by the stacks of those that there are: half of them are let go, for the work needs memory too (glibc gives back what
/// is above 40 MB of stacks). Whoever called goes on with fewer, or alone.
template <class Run>
std::vector<std::thread> start_threads(std::size_t n, Run run) {
  if (n == 0) return {};
  // A thread's first exception and first thread-local variable need memory, and glibc ends the process if there is
  // none. So each thread takes it before it works: one after another, since the first allocation of a thread borrows
  // 128 MB of addresses for a moment; and where memory is short, all of them before any works.
  const auto take_memory = [] {
    [[maybe_unused]] thread_local volatile bool taken;
    taken = std::uncaught_exceptions() == 0;
  };
  const auto gate = std::make_shared<StartGate>();
  const auto wait_for_others = [gate] {
    for (std::size_t left; (left = gate->n_missing) > 0;) gate->n_missing.wait(left);
  };

  take_memory();
  std::unique_lock closed(gate->mutex);
  std::vector<std::thread> crew;
  crew.reserve(n);
  std::size_t n_kept = n;
  try {
    for (std::size_t i = 0; i < n; ++i) {
      crew.emplace_back([=] {
        gate->n_kept.wait(StartGate::kUnknown);
        const std::size_t n_workers = gate->n_kept;
        if (i >= n_workers) return;
        std::unique_lock one_by_one(gate->mutex);
        take_memory();
        one_by_one.unlock();
        if (n_workers < n) {
          if (--gate->n_missing == 0) gate->n_missing.notify_all();
          wait_for_others();
        }
        run();
      });
      move_off_this_core(crew.back());
    }
  } catch (const std::exception&) {
    gate->n_missing = n_kept = crew.size() / 2;
  }
  gate->n_kept = n_kept;
  gate->n_kept.notify_all();
  for (; crew.size() > n_kept; crew.pop_back()) crew.back().join();
  closed.unlock();
  wait_for_others();
  return crew;
}

}  // namespace fastlines
