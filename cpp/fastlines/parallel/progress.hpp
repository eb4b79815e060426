// The state that a long call shares with its watcher: its progress, and a request to cancel it.
#pragma once

#include <atomic>
#include <exception>

namespace fastlines {

/// Thrown by a call that was asked to stop.
struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

struct Progress {
  std::atomic<double> done{0.0};  // from 0 to 1
  std::atomic<bool> cancel{false};

  /// Throws Cancelled if the call is to stop.
  void check() const {
    if (cancel.load(std::memory_order_relaxed)) throw Cancelled{};
  }
  void add(double share) { done.fetch_add(share, std::memory_order_relaxed); }
};

}  // namespace fastlines
