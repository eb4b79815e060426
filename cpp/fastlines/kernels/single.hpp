// One ray at a time, nearest node first. All leaves that it meets in a node are culled, so that neither which nor how
// many survive has to be guessed between them; what survives is tested before the next node.
#pragma once

#include "../query/search.hpp"
#include "fetch.hpp"
#include "stack.hpp"
#include "tally.hpp"

namespace fastlines {

template <class Sink>
void search_single(const WideView& tree, const Ray& ray, const CullRay& cull, Sink& sink, Stack& stack) {
  std::uint32_t survivors[kWidth * (kWidth + 1)];
  stack.clear();
  stack.push({0, ray.t_min});
  while (!stack.empty()) {
    const auto [which, at] = stack.pop();
    if (!(at <= sink.limit)) continue;
    tally(&Steps::nodes);
    const WideNode& node = tree.nodes[which];
    Float16 enter;
    const std::uint32_t lanes = cull_node(cull, node, sink.limit, enter);
    stack.push(node, lanes & ((1u << node.n_inner) - 1), enter);
    if (!stack.empty()) fetch(tree.nodes + stack.top().node);

    std::uint32_t n = 0;
    for (std::uint32_t leaves = lanes >> node.n_inner; leaves; leaves &= leaves - 1) {
      const WideLeaf& leaf = tree.leaves[node.first_leaf + std::uint32_t(std::countr_zero(leaves))];
      tally(&Steps::leaves);
      const std::uint32_t near = cull_leaf(cull.across, leaf, place_of(leaf, cull.across));
      __builtin_prefetch(tree.refs + leaf.first_ref + std::countr_zero(near | 1u << (kWidth - 1)));
      pack_numbers(near, leaf.first_ref, survivors + n);
      n += std::uint32_t(std::popcount(near));
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      __builtin_prefetch(tree.segments + tree.refs[survivors[std::min(i + 1, n - 1)]].prim);
      const Reference& ref = tree.refs[survivors[i]];
      tally(&Steps::tests);
      test_segment(ray, tree.segments[ref.prim], tree.frame, ref, sink);
    }
    if (sink.done()) return;
  }
}

}  // namespace fastlines
