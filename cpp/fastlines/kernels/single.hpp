// One ray at a time, nearest child first.
#pragma once

#include "../query/search.hpp"
#include "stack.hpp"

namespace fastlines {

template <class Sink>
void search_single(const WideView& tree, const Ray& ray, Sink& sink, Stack& stack) {
  const CullRay cull(ray);
  alignas(64) float enter[kWidth];
  const auto visit_node = [&](const WideNode& node) {
    Float16 near;
    const std::uint32_t lanes = cull_node(cull, node, sink.limit, near);
    if (lanes == 0) return;
    near.store(enter);
    stack.push(node, lanes, enter);
  };
  stack.clear();
  visit_node(tree.nodes[0]);
  while (!stack.empty()) {
    const auto [child, at] = stack.pop();
    if (!(at <= sink.limit)) continue;
    if (!(child & kLeaf)) {
      visit_node(tree.nodes[child]);
      continue;
    }
    const WideLeaf& leaf = tree.leaves[child & ~kLeaf];
    for (std::uint32_t lanes = cull_leaf(cull, leaf, LeafPlace(cull, leaf)); lanes; lanes &= lanes - 1) {
      const Reference& ref = tree.refs[leaf.first_ref + std::uint32_t(std::countr_zero(lanes))];
      test_segment(ray, tree.segments[ref.prim], tree.frame, ref, sink);
      if (sink.done()) return;
    }
  }
}

}  // namespace fastlines
