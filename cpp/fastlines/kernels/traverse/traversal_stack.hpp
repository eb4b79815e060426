// The stack of a depth-first traversal, nearest child on top.
#pragma once

#include <bit>
#include <vector>

#include "../intersect/node_cull.hpp"

namespace fastlines {

/// A node to visit, and where the ray enters it: t in the frame.
struct StackEntry {
  std::uint32_t node;
  float enter;
};

class TraversalStack {
 public:
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  StackEntry pop() { return entries_[--size_]; }
  const StackEntry& top() const { return entries_[size_ - 1]; }

  void push(StackEntry entry) {
    if (entries_.size() == size_) entries_.resize(2 * (size_ + kSimdWidth));
    entries_[size_++] = entry;
  }

  /// Push the inner children in these lanes, sorted so that the nearest is on top.
  void push(const WideNode& node, std::uint32_t lanes, const FloatX16& enters) {
    if (lanes == 0) return;
    alignas(64) float enter[kSimdWidth];
    enters.store(enter);
    if (entries_.size() < size_ + kSimdWidth) entries_.resize(2 * (size_ + kSimdWidth));
    StackEntry* const bottom = entries_.data() + size_;
    StackEntry* top = bottom;
    // Sort by insertion.
    for (; lanes; lanes &= lanes - 1) {
      const auto lane = std::uint32_t(std::countr_zero(lanes));
      const float at = enter[lane];
      StackEntry* place = top++;
      for (; place != bottom && place[-1].enter < at; --place) *place = place[-1];
      *place = {node.first_inner + lane, at};
    }
    size_ += std::size_t(top - bottom);
  }

 private:
  std::vector<StackEntry> entries_;
  std::size_t size_ = 0;
};

}  // namespace fastlines
