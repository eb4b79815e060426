// The stack of a traversal, nearest child on top.
#pragma once

#include <bit>

#include "cull.hpp"
#include "fetch.hpp"
#include "tally.hpp"

namespace fastlines {

/// A child that waits: an inner node, or a leaf (marked by its highest bit).
struct Waiting {
  std::uint32_t child;
  float enter;
};

inline constexpr std::uint32_t kLeaf = 1u << 31;

class Stack {
 public:
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  Waiting pop() { return waiting_[--size_]; }
  const Waiting& top() const { return waiting_[size_ - 1]; }

  /// Put the children of a node that the ray may meet before the limit on the stack, the nearest on top. Leaves, most
  /// of which lie far away in memory, are asked for at once.
  void visit(const WideView& tree, std::uint32_t which, const CullRay& ray, float limit) {
    tally(&Steps::nodes);
    const WideNode& node = tree.nodes[which];
    Float16 enter;
    const std::uint32_t lanes = cull_node(ray, node, limit, enter);
    for (std::uint32_t leaves = lanes >> node.n_inner; leaves; leaves &= leaves - 1)
      fetch(tree.leaves + node.first_leaf + std::countr_zero(leaves));
    push(node, lanes, enter);
  }

  void push(Waiting waiting) {
    if (waiting_.size() == size_) waiting_.resize(2 * (size_ + kWidth));
    waiting_[size_++] = waiting;
  }

  /// The children in these lanes, the nearest on top.
  void push(const WideNode& node, std::uint32_t lanes, const Float16& enters) {
    if (lanes == 0) return;
    alignas(64) float enter[kWidth];
    enters.store(enter);
    if (waiting_.size() < size_ + kWidth) waiting_.resize(2 * (size_ + kWidth));
    Waiting* const bottom = waiting_.data() + size_;
    Waiting* top = bottom;
    for (; lanes; lanes &= lanes - 1) {
      const auto lane = std::uint32_t(std::countr_zero(lanes));
      const std::uint32_t child =
          lane < node.n_inner ? node.first_inner + lane : (node.first_leaf + lane - node.n_inner) | kLeaf;
      const float at = enter[lane];
      Waiting* place = top++;
      for (; place != bottom && place[-1].enter < at; --place) *place = place[-1];
      *place = {child, at};
    }
    size_ += std::size_t(top - bottom);
  }

 private:
  std::vector<Waiting> waiting_;
  std::size_t size_ = 0;
};

}  // namespace fastlines
