// One ray at a time, nearest child first.
#pragma once

#include "../query/search.hpp"
#include "stack.hpp"

namespace fastlines {

template <class Sink>
void search_single(const WideView& tree, const Ray& ray, Sink& sink, Stack& stack) {
  const CullRay cull(ray);
  stack.clear();
  stack.visit(tree, 0, cull, sink.limit);
  while (!stack.empty()) {
    const auto [child, at] = stack.pop();
    if (!(at <= sink.limit)) continue;
    if (!(child & kLeaf)) {
      stack.visit(tree, child, cull, sink.limit);
      continue;
    }
    const WideLeaf& leaf = tree.leaves[child & ~kLeaf];
    tally(&Steps::leaves);
    for (std::uint32_t lanes = cull_leaf(cull.across, leaf, place_of(leaf, cull.across)); lanes; lanes &= lanes - 1) {
      const Reference& ref = tree.refs[leaf.first_ref + std::uint32_t(std::countr_zero(lanes))];
      tally(&Steps::tests);
      test_segment(ray, tree.segments[ref.prim], tree.frame, ref, sink);
      if (sink.done()) return;
    }
  }
}

}  // namespace fastlines
