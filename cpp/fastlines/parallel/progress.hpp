// The state that a long call shares with its watcher: its progress, and a request to cancel it.
#pragma once

#include <atomic>
#include <exception>

namespace fastlines {

/// Thrown by a call that is cancelled.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

struct Progress {
  std::atomic<double> done{0.0};  // the fraction of the work
  std::atomic<bool> cancel{false};

  /// Throws Cancelled if the watcher has requested it.
  void check() const {
    if (cancel.load(std::memory_order_relaxed)) throw Cancelled{};
  }
  /// Adds a fraction of the work to what is done.
  void add(double share) { done.fetch_add(share, std::memory_order_relaxed); }
};

}  // namespace fastlines
