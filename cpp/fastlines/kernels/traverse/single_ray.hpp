// Traces one ray at a time, nearest node first.
//
// All leaves of a node are culled together, and their survivors are tested before the next node: no branch between the
// leaves depends on which pieces survive. A stack frame is a node: a mask of the inner children that wait, and where
// each is entered. Nothing is sorted.
//
// If only one inner child is hit, it is the next node, without a search of the stack. The time to find the next node
// counts in full, and the minimum of 16 lanes takes half as long as the test of a node.
#pragma once

#include <vector>

#include "../../parallel/progress.hpp"
#include "../collect/collector.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/load_fields.hpp"
#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"
#include "../rays/spread_rays.hpp"

namespace fastlines {

struct SingleRayTuning {
  /// The most survivors of a node for which testing them one by one is faster than as a packet.
  static constexpr std::uint32_t kMaxScalarTests = 2;
};

template <RayPrimitive P>
class SingleRay {
 public:
  Checkpoint* checkpoint = nullptr;  ///< passed before leaves are culled, if there is one

  /// Report the hits of a ray to the collector. The ray is what the exact test reads: a `Ray`, or a lane of a group.
  template <class R, RayCollector C>
  void search(const WideBvhView<P>& tree, const R& ray, const CullRay& cull, C& collector) {
    search(tree, ray, cull, collector, [] {});
  }

  /// The same, where `prepare_leaves` completes `cull` before leaves are culled; many rays have none.
  template <class R, RayCollector C, class PrepareLeaves>
  void search(const WideBvhView<P>& tree_, const R& ray, const CullRay& cull, C& collector,
              PrepareLeaves&& prepare_leaves) {
    const WideBvhView<P> tree = tree_;  // a copy, so that no store can alias it
    const float& limit = collector.limit;
    std::size_t depth = 0;  // frames in use
    Next next;
    for (;;) {
      // Cull the node, and prefetch the next one.
      count_step(&StepCounters::nodes);
      const WideNode& node = tree.nodes[next.node];
      FloatX16 enter;
      const std::uint32_t lanes = cull_node(cull, node, limit, enter), inner = lanes & ((1u << node.n_inner) - 1);
      next = find_next(node, inner, enter, depth);
      prefetch(tree.nodes + next.node);
      // Cull its leaves, and test what survives.
      if (const std::uint32_t leaves = lanes >> node.n_inner) {
        if (checkpoint) checkpoint->pass(std::uint64_t(std::popcount(leaves)));
        prepare_leaves();
        if (const std::uint32_t n = cull_leaves(tree, cull, node, leaves)) {
          test_survivors(tree, ray, n, collector);
          if (limit == kNoMoreHits) return;
        }
      }
      // Pop frames that lie beyond the limit.
      while (!(next.enter <= limit)) {
        depth -= next.on_stack;
        if (depth == 0) return;
        next = find_next(depth);
      }
      // Remove the next node from its frame.
      if (next.on_stack) {
        StackFrame& frame = frames_[depth - 1];
        frame.waiting &= ~(1u << next.lane);
        depth -= frame.waiting == 0;
      }
    }
  }

 private:
  /// A node with inner children that wait: its first inner child, a mask of those that wait, and where the ray enters
  /// each child, t in the frame.
  struct StackFrame {
    alignas(64) float enter[kSimdWidth];
    std::uint32_t first_child, waiting;
  };
  /// The next node, and where the ray enters it. If it is on the stack, `lane` is its lane in the topmost frame.
  struct Next {
    std::uint32_t node = 0, lane = 0;
    float enter = kInfinity;
    bool on_stack = false;
  };

  /// The next node: the nearest of these inner children, or the nearest on the stack if there are none. Several
  /// children become a new frame.
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
    frame.first_child = node.first_inner;
    frame.waiting = inner;
    ++depth;
    return find_next(frame, enter);
  }
  /// The nearest child of the topmost frame, or one at infinity if the stack is empty.
  [[gnu::always_inline]] Next find_next(std::size_t depth) const {
    if (depth == 0) return {};
    const StackFrame& frame = frames_[depth - 1];
    return find_next(frame, FloatX16::load(frame.enter));
  }
  [[gnu::always_inline]] static Next find_next(const StackFrame& frame, const FloatX16& enter) {
    Next next{frame.first_child, 0, 0.0f, true};
    next.lane = least_lane(frame.waiting, enter, next.enter);
    next.node += next.lane;
    return next;
  }

  /// List the surviving pieces of these leaves of a node, and return their number.
  [[gnu::always_inline]] std::uint32_t cull_leaves(const WideBvhView<P>& tree, const CullRay& ray, const WideNode& node,
                                                   std::uint32_t leaves) {
    std::uint32_t n = 0;
    for (; leaves; leaves &= leaves - 1) {
      count_step(&StepCounters::leaves);
      const WideLeaf& leaf = tree.leaves[node.first_leaf + std::uint32_t(std::countr_zero(leaves))];
      const std::uint32_t near = cull_pieces<P>(ray, leaf, leaf_offset<kHasRadius<P>>(leaf, ray.projected));
      __builtin_prefetch(tree.refs + leaf.first_ref + std::countr_zero(near | 1u << (kSimdWidth - 1)));
      compress_indices(near, leaf.first_ref, survivors_ + n);
      n += std::uint32_t(std::popcount(near));
    }
    return n;
  }

  /// Test the n survivors, 16 at a time unless they are few.
  template <class R, RayCollector C>
  void test_survivors(const WideBvhView<P>& tree, const R& ray, std::uint32_t n, C& collector) {
    count_step(&StepCounters::tests, n);
    if (FloatX16::kMaxPermuteTable > 0 && n > SingleRayTuning::kMaxScalarTests) {
      for (std::uint32_t j = 0; j < n; j += kSimdWidth)
        test_packet(tree, ray, survivors_ + j, std::min(n - j, std::uint32_t(kSimdWidth)), collector);
      return;
    }
    for (std::uint32_t j = 0; j < n; ++j) {
      __builtin_prefetch(tree.items + tree.refs[survivors_[std::min(j + 1, n - 1)]].prim);
      test_one(tree, ray, tree.refs[survivors_[j]], collector);
    }
  }

  template <class R, RayCollector C>
  [[gnu::always_inline]] void test_one(const WideBvhView<P>& tree, const R& ray, const Reference& ref, C& collector) {
    const auto test = P::template test<float>(ray, fields_of<P>(tree.items[ref.prim], tree.frame));
    if (!test.closest.hit) return;
    const auto approach = approach_at(collector.at, test);
    if (approach.hit) collector.add(approach, ref);
  }

  /// Test n survivors, at most 16, with one ray.
  template <class R, RayCollector C>
  void test_packet(const WideBvhView<P>& tree, const R& ray, const std::uint32_t* refs, std::uint32_t n, C& collector) {
    const auto fields =
        load_fields(tree, [&](int i) { return tree.refs[refs[std::min(std::uint32_t(i), n - 1)]].prim; });
    const auto test = P::template test<FloatX16>(ray, fields);
    const auto approach = approach_at(collector.at, test);
    float s[kSimdWidth], t[kSimdWidth], dist2[kSimdWidth];
    approach.s.store(s);
    approach.t.store(t);
    approach.dist2.store(dist2);
    std::uint32_t hit = approach.hit.bits() & lane_mask(n);
    if constexpr (C::kDropsFarther) {  // keep the nearest, and ties with it
      const FloatX16 nearest = reduce_min(blend(hit, approach.t, kInfinity));
      hit &= may_precede(approach.t, nearest, FloatX16(ray.tie_tolerance)).bits();
    }
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      collector.add({s[i], t[i], dist2[i], true}, tree.refs[refs[i]]);
    }
  }

  std::vector<StackFrame> frames_;                          // the stack; only grows
  std::uint32_t survivors_[kSimdWidth * (kSimdWidth + 1)];  // references; 16 leaves, and 16 for compressed stores
};

}  // namespace fastlines
