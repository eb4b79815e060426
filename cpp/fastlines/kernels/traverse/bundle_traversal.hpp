// The search with a bundle of rays. In phases, none of which waits for a guess of the processor:
//
//   the node's children are culled; inner ones go onto the stack, leaves are culled at once
//   pieces that survive become segments, each once a bundle
//   their lines are seen by all rays from afar
//   where any ray may be in reach, sixteen rays are tested exactly
//
// First hits want what is nearest first, one node at a time. Where all hits are wanted their order does not matter, so
// eight nodes are taken at once, whose memory is waited for together; segments wait until they are sixteen; and pairs
// of a ray and a segment, budget of sixteen rays being far from budget segments, are tested sixteen at a time.
//
// What is in reach goes to a collector (collect.hpp), which also tells each ray's limit.
#pragma once

#include <utility>

#include "../../query/visited_set.hpp"
#include "../collect/collector.hpp"
#include "../cost/step_cost.hpp"
#include "../intersect/prefetch.hpp"
#include "../rays/ray_gather.hpp"
#include "bundle_line_test.hpp"
#include "traversal_stack.hpp"

namespace fastlines {

template <RayPrimitive P>
class BundleTraversal {
 public:
  explicit BundleTraversal(const WideBvhView<P>& tree) : tree_(tree) {}

  /// Show the collector what the rays of a bundle come near; returns what that cost. What costs more than `budget` is
  /// given up.
  template <class Collector>
  std::uint64_t search(const RayGroup& rays, RayBundle& bundle, Collector& collector, std::uint64_t budget) {
    count_step(&StepCounters::bundles);
    cost_ = BundleStepCost::kRay * std::uint64_t(bundle.end - bundle.first);
    budget_ = budget;
    float deepest = bundle.update_depths(collector.limit);
    visited_.clear();
    n_prims_ = 0;
    stack_.clear();
    stack_.push({0, bundle.axis.t_min});
    while (!stack_.empty() && cost_ <= budget) {
      nodes<Collector::kTraits.order_independent ? kNodesAtOnce : 1>(bundle.axis, deepest);
      if (n_leaves_ == 0) continue;
      segments(bundle.axis.across);
      test_all(rays, bundle, Collector::kTraits.order_independent ? kSimdWidth : 1, collector);
      if (collector.limit_changed) {
        collector.limit_changed = false;
        if constexpr (requires { collector.tighten_limits(rays, 0, 0); })
          collector.tighten_limits(rays, bundle.first, bundle.end);
        deepest = bundle.update_depths(collector.limit);
      }
    }
    test_all(rays, bundle, 1, collector);
    return cost_;
  }

 private:
  static constexpr int kNodesAtOnce = 8, kLeaves = kNodesAtOnce * kSimdWidth, kPieces = (kLeaves + 1) * kSimdWidth;
  static constexpr int kMaxPairsPerPacket =
      13;  // of sixteen rays near a segment: beyond it, to pick pairs costs more than it saves

  /// What was seen from afar: packs with any ray near, where order does not matter rays near in all of them, and tests
  /// of sixteen pairs of these.
  struct Near {
    int n_packs = 0, n_rays = 0, n_tests = 0;
  };

  /// Take up to n nodes from the stack, and list those of their children that are leaves.
  template <int n>
  void nodes(const CullRay& axis, float deepest) {
    StackEntry next[n];
    int n_next = 0;
    while (n_next < n && !stack_.empty()) {
      next[n_next] = stack_.pop();
      n_next += next[n_next].enter <= deepest;
    }
    count_step(&StepCounters::nodes, std::uint64_t(n_next));
    cost_ += BundleStepCost::kNode * std::uint64_t(n_next);
    int n_leaves = 0;  // in a register: a count in memory would be waited for
    for (int i = 0; i < n_next; ++i) {
      const WideNode& node = tree_.nodes[next[i].node];
      FloatX16 enter;
      const std::uint32_t lanes = cull_node(axis, node, deepest, enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      compress_indices(lanes ^ inner, node.first_leaf - node.n_inner, leaves_ + n_leaves);
      n_leaves += std::popcount(lanes ^ inner);
      stack_.push(node, inner, enter);
    }
    n_leaves_ = n_leaves;
    if (!stack_.empty()) prefetch(tree_.nodes + stack_.top().node);
    for (int i = 0; i < n_leaves; ++i) prefetch(tree_.leaves + leaves_[i]);
  }

  /// Append the segments whose pieces in these leaves survive, but for those that the bundle has met already.
  void segments(const ProjectedRay& axis) {
    // Where the next leaf lies is found before this one is tested; beyond the last any will do. The references of
    // budget leaves will be wanted.
    leaves_[n_leaves_] = leaves_[0];
    LeafOffset next = leaf_offset<P::kHasRadius>(tree_.leaves[leaves_[0]], axis);
    int n_pieces = 0;
    const WideBvhView<P> tree = tree_;  // a copy, so that nothing written can alias it
    for (int i = 0, n = n_leaves_; i < n; ++i) {
      const WideLeaf& leaf = tree.leaves[leaves_[i]];
      const LeafOffset place = std::exchange(next, leaf_offset<P::kHasRadius>(tree.leaves[leaves_[i + 1]], axis));
      prefetch_refs(tree, leaf);
      const std::uint32_t lanes = cull_leaf(axis, leaf, place);
      compress_indices(lanes, leaf.first_ref, pieces_ + n_pieces);
      n_pieces += std::popcount(lanes);
    }
    count_step(&StepCounters::leaves, std::uint64_t(n_leaves_));
    count_step(&StepCounters::pieces, std::uint64_t(n_pieces));
    cost_ += BundleStepCost::kLeaf * std::uint64_t(n_leaves_);
    visited_.reserve(std::size_t(n_pieces));
    int n_prims = n_prims_;
    for (int j = 0; j < n_pieces; ++j) {
      const std::uint32_t prim = tree.refs[pieces_[j]].prim;
      __builtin_prefetch(tree.items + prim);
      prims_[n_prims] = prim;
      n_prims += visited_.insert(prim);
    }
    n_prims_ = n_prims;
  }

  /// Test the segments that wait, sixteen at a time, as long as there are so many.
  template <class Collector>
  void test_all(const RayGroup& rays, const RayBundle& bundle, int at_least, Collector& collector) {
    int i = 0;
    for (; n_prims_ - i >= at_least && cost_ <= budget_; i += kSimdWidth)
      test(rays, bundle, prims_ + i, std::min(n_prims_ - i, kSimdWidth), collector);
    if (i == 0) return;
    n_prims_ = std::max(n_prims_ - i, 0);
    std::copy_n(prims_ + i, n_prims_, prims_);
  }

  template <class Collector>
  void test(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n, Collector& collector) {
    line_test_.load(tree_, prims, bundle);
    const int n_lines = n * (bundle.end - bundle.first) / kSimdWidth;
    Near near;
    bool as_pairs = false;
    if constexpr (Collector::kTraits.order_independent && FloatX16::kMaxPermuteTable > 0) {
      as_pairs = use_pairs_;
      if (as_pairs) near = test_pairs<FloatX16>(rays, bundle, prims, n, collector);
    }
    if (!as_pairs) near = test_packs(rays, bundle, prims, n, collector);
    use_pairs_ = near.n_rays <= kMaxPairsPerPacket * near.n_packs;
    const int n_tests = as_pairs ? near.n_tests : near.n_packs;
    count_step(&StepCounters::segments, std::uint64_t(n));
    count_step(&StepCounters::lines, std::uint64_t(n_lines));
    count_step(&StepCounters::packs, std::uint64_t(n_tests));
    cost_ += BundleStepCost::kSegment * std::uint64_t(n) + BundleStepCost::kLine * std::uint64_t(n_lines) +
             BundleStepCost::kPack * std::uint64_t(n_tests);
  }

  /// Test sixteen rays beside one segment at a time.
  template <class Collector>
  Near test_packs(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n,
                  Collector& collector) {
    Near seen;
    line_test_.test(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      packs_[seen.n_packs] = first + j;
      seen.n_packs += near != 0;
      if constexpr (Collector::kTraits.order_independent) seen.n_rays += std::popcount(near);
    });
    for (int i = 0; i < seen.n_packs; ++i) {
      const int j = packs_[i] % kSimdWidth, first = packs_[i] - j;
      Lanes<P, float> lanes;
      for (int k = 0; k < P::kLanes; ++k) lanes[k] = line_test_.lanes[k][j];
      const PacketView packet(rays, first);
      const auto test = P::template test<FloatX16>(packet, lanes);
      const auto& approach = approach_at<Collector::kAt>(test);
      // Without asking first whether any hits: the guess would be known to be wrong only at the end of a long test.
      const std::uint32_t hit = approach.hit.bits() & lane_mask(std::size_t(rays.n - first));
      collector.add_packet(rays, first, hit, approach, prims[j]);
    }
    return seen;
  }

  /// Test rays beside the segments that each may come near, sixteen pairs at a time. F is FloatX16: named, so that this
  /// is compiled only where it can look up.
  template <class F, class Collector>
  Near test_pairs(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n,
                  Collector& collector) {
    Near seen;
    int n_pairs[kGroupSize / kSimdWidth] = {};  // of each sixteen rays
    line_test_.test(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      int& n_here = n_pairs[first / kSimdWidth];
      compress_indices(near, std::uint32_t(j * kSimdWidth), pairs_[first / kSimdWidth] + n_here);
      n_here += std::popcount(near);
      seen.n_packs += near != 0;
    });
    for (int first = bundle.first; first < bundle.end; first += kSimdWidth) {
      const std::uint32_t* pair = pairs_[first / kSimdWidth];
      int left = n_pairs[first / kSimdWidth];
      seen.n_rays += left;
      for (; left > 0; left -= kSimdWidth, pair += kSimdWidth, ++seen.n_tests) {
        std::uint32_t ray[kSimdWidth], segment[kSimdWidth];
        for (int i = 0; i < kSimdWidth; ++i) {
          ray[i] = pair[i] % kSimdWidth;
          segment[i] = pair[i] / kSimdWidth;
        }
        const PermutedRays<F> packet(rays, first, ray);
        Lanes<P, F> lanes;
        for (int k = 0; k < P::kLanes; ++k) lanes[k] = F::permute(line_test_.lanes[k], segment);
        const auto test = P::template test<F>(packet, lanes);
        const auto& approach = approach_at<Collector::kAt>(test);
        const std::uint32_t hit = approach.hit.bits() & lane_mask(std::size_t(left));
        if (hit) collector.add_pairs(first, hit, approach, ray, F::permute(as_floats(prims), segment));
      }
    }
    return seen;
  }

  const WideBvhView<P>& tree_;
  std::uint64_t cost_ = 0, budget_ = 0;
  TraversalStack stack_;
  VisitedSet visited_;
  BundleLineTest<P> line_test_{};
  int packs_[kSimdWidth *
             (kGroupSize / kSimdWidth)];  // the first of sixteen rays, plus the segment they are tested beside
  // WorkList, a list for each sixteen rays: sixteen times the segment, plus the ray.
  std::uint32_t pairs_[kGroupSize / kSimdWidth][(kSimdWidth + 1) * kSimdWidth] = {};
  std::uint32_t leaves_[kLeaves + kSimdWidth], pieces_[kPieces];
  std::uint32_t prims_[kPieces + kSimdWidth] = {};  // past the last stand any others: sixteen are read
  int n_leaves_ = 0;
  bool use_pairs_ = true;  // of the lines seen last
  int n_prims_ = 0;        // that wait to be tested
};

}  // namespace fastlines
