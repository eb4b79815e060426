// The stack of a traversal, nearest node on top.
#pragma once

#include <bit>

#include "cull.hpp"

namespace fastlines {

/// A node that waits.
struct Waiting {
  std::uint32_t node;
  float enter;
};

class Stack {
 public:
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  Waiting pop() { return waiting_[--size_]; }
  const Waiting& top() const { return waiting_[size_ - 1]; }

  void push(Waiting waiting) {
    if (waiting_.size() == size_) waiting_.resize(2 * (size_ + kWidth));
    waiting_[size_++] = waiting;
  }

  /// The inner children in these lanes, the nearest on top.
  void push(const WideNode& node, std::uint32_t lanes, const Float16& enters) {
    if (lanes == 0) return;
    alignas(64) float enter[kWidth];
    enters.store(enter);
    if (waiting_.size() < size_ + kWidth) waiting_.resize(2 * (size_ + kWidth));
    Waiting* const bottom = waiting_.data() + size_;
    Waiting* top = bottom;
    for (; lanes; lanes &= lanes - 1) {
      const auto lane = std::uint32_t(std::countr_zero(lanes));
      const float at = enter[lane];
      Waiting* place = top++;
      for (; place != bottom && place[-1].enter < at; --place) *place = place[-1];
      *place = {node.first_inner + lane, at};
    }
    size_ += std::size_t(top - bottom);
  }

 private:
  std::vector<Waiting> waiting_;
  std::size_t size_ = 0;
};

}  // namespace fastlines
