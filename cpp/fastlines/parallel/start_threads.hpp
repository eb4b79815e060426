// Starts threads that work together, as many as the system allows.
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

/// Moves a thread that was just started off the calling thread's core, which is busy. The system may otherwise leave it
/// there for milliseconds, until it next looks for idle cores. Afterwards the thread may run anywhere. The calls are
/// hints: if they are refused, the thread starts where the system put it.
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

/// Holds threads back until it is known how many of them will work.
struct StartGate {
  static constexpr auto kUnknown = std::numeric_limits<std::size_t>::max();
  std::atomic<std::size_t> n_kept{kUnknown}, n_missing{0};  // threads that will work, and those not ready yet
  std::mutex mutex;                                         // lets one thread at a time allocate
};

/// Starts up to n threads and returns them. They call run() once their number is known.
///
/// If the system refuses a thread, the stacks of the others may have used up the memory that the work needs. So half of
/// them end (glibc then frees stacks beyond 40 MB), and the caller continues with fewer threads, or alone.
template <class Run>
std::vector<std::thread> start_threads(std::size_t n, Run run) {
  if (n == 0) return {};
  // The first exception and the first thread-local variable of a thread allocate memory, and glibc ends the process if
  // there is none. So each thread allocates that memory before it works. Threads do so one after another, because the
  // first allocation of a thread briefly reserves 128 MB of addresses. If the system has refused a thread, no thread
  // works before all have allocated.
  const auto allocate_early = [] {
    [[maybe_unused]] thread_local volatile bool allocated;
    allocated = std::uncaught_exceptions() == 0;
  };
  const auto gate = std::make_shared<StartGate>();
  const auto wait_for_others = [gate] {
    for (std::size_t left; (left = gate->n_missing) > 0;) gate->n_missing.wait(left);
  };

  allocate_early();
  std::unique_lock closed(gate->mutex);
  std::vector<std::thread> threads;
  threads.reserve(n);
  std::size_t n_kept = n;
  try {
    for (std::size_t i = 0; i < n; ++i) {
      threads.emplace_back([=] {
        gate->n_kept.wait(StartGate::kUnknown);
        const std::size_t n_workers = gate->n_kept;
        if (i >= n_workers) return;
        std::unique_lock lock(gate->mutex);
        allocate_early();
        lock.unlock();
        if (n_workers < n) {
          if (--gate->n_missing == 0) gate->n_missing.notify_all();
          wait_for_others();
        }
        run();
      });
      move_off_this_core(threads.back());
    }
  } catch (const std::exception&) {
    gate->n_missing = n_kept = threads.size() / 2;
  }
  gate->n_kept = n_kept;
  gate->n_kept.notify_all();
  for (; threads.size() > n_kept; threads.pop_back()) threads.back().join();
  closed.unlock();
  wait_for_others();
  return threads;
}

}  // namespace fastlines
