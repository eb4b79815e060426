// One ray at a time, nearest node first. All leaves that it meets in a node are culled, so that neither which nor how
// many survive has to be guessed between them; what survives is tested before the next node.
//
// As in a wave, an entry of the stack is a node of which inner children wait, and where each is entered: nothing has to
// be put in order. But a child that is the only one comes next without a find_next at the stack: rays wait for what
// comes next, and to find the least of sixteen takes half as long as a node's test.
#pragma once

#include <limits>
#include <vector>

#include "../collect/collector.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/exact_test.hpp"
#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"

namespace fastlines {

template <RayPrimitive P>
class SingleRay {
 public:
  explicit SingleRay(const WideBvhView<P>& tree) : tree_(tree) {}

  /// Show the collector what the ray in this lane comes near.
  template <class Collector>
  void search(const RayGroup& rays, int lane, const CullRay& cull, Collector& collector) {
    const WideBvhView<P> tree = tree_;  // a copy, so that nothing written can alias it
    const float& limit = collector.limit[lane];
    std::size_t depth = 0;  // levels in use
    Next next;
    for (;;) {
      count_step(&StepCounters::nodes);
      const WideNode& node = tree.nodes[next.node];
      FloatX16 enter;
      const std::uint32_t lanes = cull_node(cull, node, limit, enter), inner = lanes & ((1u << node.n_inner) - 1);
      next = find_next(node, inner, enter, depth);
      prefetch(tree.nodes + next.node);
      if (const std::uint32_t n = cull_leaves(tree, cull.across, node, lanes >> node.n_inner)) {
        test(rays, lane, n, collector);
        if (limit == kNoMoreHits) return;
      }
      while (!(next.enter <= limit)) {
        depth -= next.on_stack;
        if (depth == 0) return;
        next = find_next(depth);
      }
      if (next.on_stack) {
        StackFrame& frame = frames_[depth - 1];
        frame.waiting &= ~(1u << next.lane);
        depth -= frame.waiting == 0;
      }
    }
  }

 private:
  static constexpr float kNever = std::numeric_limits<float>::infinity();
  static constexpr std::uint32_t kMaxScalarTests = 2;  // to test so many pieces one by one is quicker

  /// A node of which these children wait, as bits.
  struct StackFrame {
    alignas(64) float enter[kSimdWidth];
    std::uint32_t first, waiting;
  };
  /// The node that comes next, and where it is entered; on the stack in this lane of the topmost frame, or not.
  struct Next {
    std::uint32_t node = 0, lane = 0;
    float enter = kNever;
    bool on_stack = false;
  };

  /// What comes next: of these children of a node, if there are any, else of what waits.
  [[gnu::always_inline]] Next find_next(const WideNode& node, std::uint32_t inner, const FloatX16& enter,
                                        std::size_t& depth) {
    if (inner == 0) return find_next(depth);
    if (frames_.size() == depth) frames_.resize(2 * depth + 8);
    StackFrame& frame = frames_[depth];
    enter.store(frame.enter);
    if ((inner & (inner - 1)) == 0) {
      const auto lane = std::uint32_t(std::countr_zero(inner));
      return {node.first_inner + lane, lane, frame.enter[lane], false};
    }
    frame.first = node.first_inner;
    frame.waiting = inner;
    ++depth;
    return find_next(frame, enter);
  }
  [[gnu::always_inline]] Next find_next(std::size_t depth) const {
    if (depth == 0) return {};
    const StackFrame& frame = frames_[depth - 1];
    return find_next(frame, FloatX16::load(frame.enter));
  }
  [[gnu::always_inline]] static Next find_next(const StackFrame& frame, const FloatX16& enter) {
    const FloatX16 waiting = blend(frame.waiting, enter, kNever);
    const float first = reduce_min(waiting);
    const auto lane = std::uint32_t(std::countr_zero((waiting <= FloatX16(first)).bits()));
    return {frame.first + lane, lane, first, true};
  }

  /// List the pieces of these leaves of a node that survive; returns how many.
  [[gnu::always_inline]] std::uint32_t cull_leaves(const WideBvhView<P>& tree, const ProjectedRay& across,
                                                   const WideNode& node, std::uint32_t leaves) {
    std::uint32_t n = 0;
    for (; leaves; leaves &= leaves - 1) {
      count_step(&StepCounters::leaves);
      const WideLeaf& leaf = tree.leaves[node.first_leaf + std::uint32_t(std::countr_zero(leaves))];
      const std::uint32_t near = cull_leaf(across, leaf, leaf_offset<P::kHasRadius>(leaf, across));
      __builtin_prefetch(tree.refs + leaf.first_ref + std::countr_zero(near | 1u << (kSimdWidth - 1)));
      compress_indices(near, leaf.first_ref, survivors_ + n);
      n += std::uint32_t(std::popcount(near));
    }
    return n;
  }

  /// Test the first n survivors: sixteen at a time where they are more than a few.
  template <class Collector>
  void test(const RayGroup& rays, int lane, std::uint32_t n, Collector& collector) {
    count_step(&StepCounters::tests, n);
    if (FloatX16::kMaxPermuteTable > 0 && n > kMaxScalarTests) {
      for (std::uint32_t j = 0; j < n; j += kSimdWidth)
        test_packet(rays, lane, survivors_ + j, std::min(n - j, std::uint32_t(kSimdWidth)), collector);
      return;
    }
    for (std::uint32_t j = 0; j < n; ++j) {
      __builtin_prefetch(tree_.items + tree_.refs[survivors_[std::min(j + 1, n - 1)]].prim);
      test_one(rays, lane, tree_.refs[survivors_[j]], collector);
    }
  }

  /// Test one piece.
  template <class Collector>
  [[gnu::always_inline]] void test_one(const RayGroup& rays, int lane, const Reference& ref, Collector& collector) {
    const LaneView ray(rays, lane);
    const auto test = P::template test<float>(ray, lanes_of<P>(tree_.items[ref.prim], tree_.frame));
    if (test.closest.hit) collector.add_hit(rays, lane, approach_at<Collector::kAt>(test), ref);
  }

  template <class Collector>
  void test_packet(const RayGroup& rays, int lane, const std::uint32_t* which, std::uint32_t n, Collector& collector) {
    const LaneView ray(rays, lane);
    const auto lanes =
        load_lanes(tree_, [&](int i) { return tree_.refs[which[std::min(std::uint32_t(i), n - 1)]].prim; });
    const auto test = P::template test<FloatX16>(ray, lanes);
    const auto& approach = approach_at<Collector::kAt>(test);
    float s[kSimdWidth], t[kSimdWidth], dist2[kSimdWidth];
    approach.s.store(s);
    approach.t.store(t);
    approach.dist2.store(dist2);
    std::uint32_t hit = approach.hit.bits() & lane_mask(n);
    if constexpr (Collector::kTraits.drops_farther) {
      const FloatX16 nearest = reduce_min(blend(hit, approach.t, kNever));
      hit &= may_precede(approach.t, nearest, FloatX16(rays.tie_tolerance[lane])).bits();
    }
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      collector.add_hit(rays, lane, {s[i], t[i], dist2[i], true}, tree_.refs[which[i]]);
    }
  }

  const WideBvhView<P>& tree_;
  std::vector<StackFrame> frames_;  // the stack
  std::uint32_t survivors_[kSimdWidth * (kSimdWidth + 1)];
};

}  // namespace fastlines
