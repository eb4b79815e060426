// What a long call shares with whoever watches it: how far it is, and whether it should stop.
#pragma once

#include <atomic>
#include <exception>

namespace fastlines {

struct Cancelled : std::exception {
  const char* what() const noexcept override { return "cancelled"; }
};

struct Progress {
  std::atomic<double> done{0.0};  // from 0 to 1
  std::atomic<bool> cancel{false};

  void check() const {
    if (cancel.load(std::memory_order_relaxed)) throw Cancelled{};
  }
  void add(double share) { done.fetch_add(share, std::memory_order_relaxed); }
};

}  // namespace fastlines
