// The state that a long call shares with its watcher: its progress, and a request to cancel it.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <thread>

#include "../memory/function_ref.hpp"

namespace fastlines {

/// Thrown by a call that is cancelled.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

/// The interval at which a watcher polls for cancellation.
inline constexpr std::chrono::milliseconds kPollInterval{50};

/// The fraction to show. Threads report their shares in any order, and rounding may raise their sum above 1.
inline double shown_of(const std::atomic<double>& done, double shown_before) {
  return std::clamp(done.load(), shown_before, 1.0);
}

class Progress {
 public:
  std::atomic<double> done{0.0};  // the fraction of the work
  std::atomic<bool> cancel{false};
  double per_step = 0.0;  // at most the fraction of the work that is one step of `Checkpoint`

  Progress() = default;
  /// The progress of work on the watcher's own thread, which then asks poll(done) itself whether to go on. Threads that
  /// help do not.
  explicit Progress(const FunctionRef<bool(double)>* poll) : poll_(poll) {}

  /// Throws Cancelled if the watcher has requested it.
  void check() const {
    if (cancel.load(std::memory_order_relaxed)) throw Cancelled{};
    if (poll_ && std::this_thread::get_id() == watcher_) poll();
  }
  /// Adds a fraction of the work to what is done. libc++ has no fetch_add of doubles before version 18.
  void add(double share) {
    constexpr auto relaxed = std::memory_order_relaxed;
    for (double before = done.load(relaxed); !done.compare_exchange_weak(before, before + share, relaxed);) continue;
  }

 private:
  void poll() const {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_poll_ < kPollInterval) return;
    if (!(*poll_)(shown_ = shown_of(done, shown_))) throw Cancelled{};
    last_poll_ = std::chrono::steady_clock::now();
  }

  const FunctionRef<bool(double)>* poll_ = nullptr;
  // The rest is of the watcher's thread.
  std::thread::id watcher_ = std::this_thread::get_id();
  mutable std::chrono::steady_clock::time_point last_poll_ = std::chrono::steady_clock::now();
  mutable double shown_ = 0.0;
};

/// What a thread passes at every step of a long task; it costs few instructions.
class Checkpoint {
 public:
  explicit Checkpoint(Progress& progress) : progress_(progress) {}

  /// Throws Cancelled if the watcher has requested it; counts steps as done.
  [[gnu::always_inline]] void pass(std::uint64_t n_steps = 1) {
    n_steps_ += n_steps;
    if ((n_steps_ >= kStepsPerReport) | progress_.cancel.load(std::memory_order_relaxed)) [[unlikely]]
      report();
  }

  /// The same after a part of the work that takes milliseconds.
  void check() const { progress_.check(); }

 private:
  static constexpr std::uint64_t kStepsPerReport = 1 << 14;

  [[gnu::noinline, gnu::cold]] void report() {
    progress_.add(double(n_steps_) * progress_.per_step);
    n_steps_ = 0;
    progress_.check();
  }

  Progress& progress_;
  std::uint64_t n_steps_ = 0;
};

/// Call work(i) for i in [0, n), and pass the checkpoint now and then, if there is one.
template <class Work>
[[gnu::always_inline]] inline void for_each_index(std::uint32_t n, Checkpoint* checkpoint, const Work& work) {
  constexpr std::uint32_t at_once = 1 << 20;
  for (std::uint32_t begin = 0; begin < n;) {
    const std::uint32_t end = n - begin > at_once ? begin + at_once : n;
    for (std::uint32_t i = begin; i < end; ++i) work(i);
    begin = end;
    if (checkpoint) checkpoint->check();
  }
}

}  // namespace fastlines
