// One ray at a time, nearest node first. All leaves that it meets in a node are culled, so that neither which nor how
// many survive has to be guessed between them; what survives is tested before the next node.
//
// As in a wave, an entry of the stack is a node of which inner children wait, and where each is entered: nothing has to
// be put in order. But a child that is the only one comes next without a look at the stack: rays wait for what comes
// next, and to find the least of sixteen takes half as long as a node's test.
#pragma once

#include <limits>
#include <vector>

#include "collect.hpp"
#include "cull.hpp"
#include "fetch.hpp"
#include "sixteen.hpp"
#include "tally.hpp"

namespace fastlines {

class Single {
 public:
  explicit Single(const WideView& tree) : tree_(tree) {}

  /// Show the collector what the ray in this lane comes near.
  template <class Collector>
  void search(const RayLanes& rays, int lane, const CullRay& cull, Collector& collector) {
    const WideView tree = tree_;  // a copy, so that nothing written can alias it
    const float& limit = collector.limit[lane];
    std::size_t depth = 0;  // levels in use
    Next next;
    for (;;) {
      tally(&Steps::nodes);
      const WideNode& node = tree.nodes[next.node];
      Float16 enter;
      const std::uint32_t lanes = cull_node(cull, node, limit, enter), inner = lanes & ((1u << node.n_inner) - 1);
      next = look(node, inner, enter, depth);
      fetch(tree.nodes + next.node);
      if (const std::uint32_t n = cull_leaves(tree, cull.across, node, lanes >> node.n_inner)) {
        test(rays, lane, n, collector);
        if (limit == kOut) return;
      }
      while (!(next.enter <= limit)) {
        depth -= next.on_stack;
        if (depth == 0) return;
        next = look(depth);
      }
      if (next.on_stack) {
        Level& level = levels_[depth - 1];
        level.waiting &= ~(1u << next.lane);
        depth -= level.waiting == 0;
      }
    }
  }

 private:
  static constexpr float kNever = std::numeric_limits<float>::infinity();
  static constexpr std::uint32_t kFew = 2;  // to test so many pieces one by one is quicker

  /// A node of which these children wait, as bits.
  struct Level {
    alignas(64) float enter[kWidth];
    std::uint32_t first, waiting;
  };
  /// The node that comes next, and where it is entered; on the stack in this lane of the topmost level, or not.
  struct Next {
    std::uint32_t node = 0, lane = 0;
    float enter = kNever;
    bool on_stack = false;
  };

  /// What comes next: of these children of a node, if there are any, else of what waits.
  [[gnu::always_inline]] Next look(const WideNode& node, std::uint32_t inner, const Float16& enter,
                                   std::size_t& depth) {
    if (inner == 0) return look(depth);
    if (levels_.size() == depth) levels_.resize(2 * depth + 8);
    Level& level = levels_[depth];
    enter.store(level.enter);
    if ((inner & (inner - 1)) == 0) {
      const auto lane = std::uint32_t(std::countr_zero(inner));
      return {node.first_inner + lane, lane, level.enter[lane], false};
    }
    level.first = node.first_inner;
    level.waiting = inner;
    ++depth;
    return look(level, enter);
  }
  [[gnu::always_inline]] Next look(std::size_t depth) const {
    if (depth == 0) return {};
    const Level& level = levels_[depth - 1];
    return look(level, Float16::load(level.enter));
  }
  [[gnu::always_inline]] static Next look(const Level& level, const Float16& enter) {
    const Float16 waiting = choose(level.waiting, enter, kNever);
    const float first = least(waiting);
    const auto lane = std::uint32_t(std::countr_zero((waiting <= Float16(first)).bits()));
    return {level.first + lane, lane, first, true};
  }

  /// List the pieces of these leaves of a node that survive; returns how many.
  [[gnu::always_inline]] std::uint32_t cull_leaves(const WideView& tree, const Across& across, const WideNode& node,
                                                   std::uint32_t leaves) {
    std::uint32_t n = 0;
    for (; leaves; leaves &= leaves - 1) {
      tally(&Steps::leaves);
      const WideLeaf& leaf = tree.leaves[node.first_leaf + std::uint32_t(std::countr_zero(leaves))];
      const std::uint32_t near = cull_leaf(across, leaf, place_of(leaf, across));
      __builtin_prefetch(tree.refs + leaf.first_ref + std::countr_zero(near | 1u << (kWidth - 1)));
      pack_numbers(near, leaf.first_ref, survivors_ + n);
      n += std::uint32_t(std::popcount(near));
    }
    return n;
  }

  /// Test the first n survivors: sixteen at a time where they are more than a few.
  template <class Collector>
  void test(const RayLanes& rays, int lane, std::uint32_t n, Collector& collector) {
    tally(&Steps::tests, n);
    if (Float16::kLooksUp > 0 && n > kFew) {
      for (std::uint32_t j = 0; j < n; j += kWidth)
        test_sixteen(rays, lane, survivors_ + j, std::min(n - j, std::uint32_t(kWidth)), collector);
      return;
    }
    for (std::uint32_t j = 0; j < n; ++j) {
      __builtin_prefetch(tree_.segments + tree_.refs[survivors_[std::min(j + 1, n - 1)]].prim);
      test_one(tree_, rays, lane, tree_.refs[survivors_[j]], collector);
    }
  }

  template <class Collector>
  void test_sixteen(const RayLanes& rays, int lane, const std::uint32_t* which, std::uint32_t n, Collector& collector) {
    const RayInLane ray(rays, lane);
    Float16 start[3], e[3];
    take_sixteen(tree_, [&](int i) { return tree_.refs[which[std::min(std::uint32_t(i), n - 1)]].prim; }, start, e);
    const Seen<Float16> seen = see<Float16>(ray, start, e);
    Approach<Float16> approach = closest_approach(ray, seen);
    if constexpr (Collector::kAt == At::surface) approach = entry(ray, seen, approach);
    float s[kWidth], t[kWidth], dist2[kWidth];
    approach.s.store(s);
    approach.t.store(t);
    approach.dist2.store(dist2);
    std::uint32_t hit = approach.hit.bits() & first_lanes(n);
    if constexpr (Collector::kOnlyNearest) {
      const Float16 nearest = least(choose(hit, approach.t, kNever));
      hit &= may_come_first(approach.t, nearest, Float16(rays.margin[lane])).bits();
    }
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      collector.take_one(rays, lane, {s[i], t[i], dist2[i], true}, tree_.refs[which[i]]);
    }
  }

  const WideView& tree_;
  std::vector<Level> levels_;  // the stack
  std::uint32_t survivors_[kWidth * (kWidth + 1)];
};

}  // namespace fastlines
