// Traces a bundle of coherent rays, in phases without unpredictable branches:
//
//   nodes        the axis culls the children of a node: inner ones go to the stack, leaves to a list
//   leaves       the axis culls the leaves; surviving pieces become segments, each once per bundle
//   lines        a cheap conservative test compares the segments' lines with packets of rays (bundle_line_test.hpp)
//   exact tests  packets in which some ray may hit are tested exactly
//
// First hits take the nearest node first, one at a time. If order does not matter, several nodes are taken at once, so
// that their memory is fetched together, and segments are buffered until there are 16. Few of 16 rays come near any one
// segment then, so (ray, segment) pairs are tested instead, 16 at a time.
//
// Hits go to a collector (collector.hpp), which also gives the limit of each ray.
#pragma once

#include <utility>

#include "../../parallel/progress.hpp"
#include "../../query/visited_set.hpp"
#include "../collect/collector.hpp"
#include "../cost/step_cost.hpp"
#include "../intersect/prefetch.hpp"
#include "../rays/ray_gather.hpp"
#include "bundle_line_test.hpp"
#include "traversal_stack.hpp"

namespace fastlines {

struct BundleTraversalTuning {
  /// Nodes taken from the stack at once if order does not matter. More overlap more cache misses, with larger buffers.
  static constexpr int kNodesAtOnce = 8;
  /// Rays of a packet that come near a segment, on average. With more of them, compressing pairs costs more than it
  /// saves, and whole packets are tested.
  static constexpr int kMaxPairsPerPacket = 13;
};

template <RayPrimitive P>
class BundleTraversal {
 public:
  BundleTraversal(const WideBvhView<P>& tree, Checkpoint& checkpoint) : tree_(tree), checkpoint_(checkpoint) {}

  /// Report the hits of the rays of a bundle to the collector. Returns the cost in cycles. A search that costs more
  /// than `budget` cycles is aborted; the hits are then incomplete.
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
      cull_nodes<Collector::kTraits.order_independent ? kNodesAtOnce : 1>(bundle.axis, deepest);
      checkpoint_.pass(std::uint64_t(n_leaves_) * std::uint64_t(bundle.end - bundle.first));
      if (n_leaves_ == 0) continue;
      cull_leaves(bundle.axis.projected);
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
  static constexpr int kNodesAtOnce = BundleTraversalTuning::kNodesAtOnce;
  static constexpr int kMaxLeaves = kNodesAtOnce * kSimdWidth, kMaxPieces = (kMaxLeaves + 1) * kSimdWidth;

  /// Results of a line test.
  struct Counts {
    int n_packets = 0;  // (packet, segment) pairs with a ray nearby
    int n_rays = 0;     // rays nearby in all of these pairs; counted only if order does not matter
    int n_tests = 0;    // exact tests of 16 (ray, segment) pairs
  };

  /// Take up to n nodes from the stack and cull their children with the axis. Inner ones go to the stack, leaves to
  /// `leaves_`. No ray needs hits beyond `deepest`, t of the axis.
  template <int n>
  void cull_nodes(const CullRay& axis, float deepest) {
    // Take nodes that begin before the limit.
    StackEntry next[n];
    int n_next = 0;
    while (n_next < n && !stack_.empty()) {
      next[n_next] = stack_.pop();
      n_next += next[n_next].enter <= deepest;
    }
    count_step(&StepCounters::nodes, std::uint64_t(n_next));
    cost_ += BundleStepCost::kNode * std::uint64_t(n_next);
    int n_leaves = 0;  // in a register: a count in memory would be stored and reloaded in each iteration
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

  /// Cull the listed leaves with the axis. Append the segments of the surviving pieces, except those that the bundle
  /// has visited.
  void cull_leaves(const ProjectedRay& axis) {
    // Compute the offset of a leaf while the one before it is tested. The last leaf is followed by the first one. The
    // references of most leaves will be needed, so prefetch all.
    leaves_[n_leaves_] = leaves_[0];
    LeafOffset next = leaf_offset<kHasRadius<P>>(tree_.leaves[leaves_[0]], axis);
    int n_pieces = 0;
    const WideBvhView<P> tree = tree_;  // a copy, so that no store can alias it
    for (int i = 0, n = n_leaves_; i < n; ++i) {
      const WideLeaf& leaf = tree.leaves[leaves_[i]];
      const LeafOffset offset = std::exchange(next, leaf_offset<kHasRadius<P>>(tree.leaves[leaves_[i + 1]], axis));
      prefetch_refs(tree, leaf);
      const std::uint32_t lanes = cull_leaf(axis, leaf, offset);
      compress_indices(lanes, leaf.first_ref, pieces_ + n_pieces);
      n_pieces += std::popcount(lanes);
    }
    count_step(&StepCounters::leaves, std::uint64_t(n_leaves_));
    count_step(&StepCounters::pieces, std::uint64_t(n_pieces));
    cost_ += BundleStepCost::kLeaf * std::uint64_t(n_leaves_);
    // Append segments that are not yet visited.
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

  /// Test the buffered segments, 16 at a time, while at least `min_segments` are left and the budget lasts.
  template <class Collector>
  void test_all(const RayGroup& rays, const RayBundle& bundle, int min_segments, Collector& collector) {
    int i = 0;
    for (; n_prims_ - i >= min_segments && cost_ <= budget_; i += kSimdWidth)
      test_segments(rays, bundle, prims_ + i, std::min(n_prims_ - i, kSimdWidth), collector);
    if (i == 0) return;
    n_prims_ = std::max(n_prims_ - i, 0);
    std::copy_n(prims_ + i, n_prims_, prims_);
  }

  /// Test n segments, at most 16, with the rays of the bundle: as pairs if the previous segments had few rays nearby.
  template <class Collector>
  void test_segments(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n,
                     Collector& collector) {
    line_test_.load(tree_, prims, bundle);
    const int n_lines = n * (bundle.end - bundle.first) / kSimdWidth;
    Counts counts;
    bool as_pairs = false;
    if constexpr (Collector::kTraits.order_independent && FloatX16::kMaxPermuteTable > 0) {
      as_pairs = use_pairs_;
      if (as_pairs) counts = test_pairs<FloatX16>(rays, bundle, prims, n, collector);
    }
    if (!as_pairs) counts = test_packets(rays, bundle, prims, n, collector);
    use_pairs_ = counts.n_rays <= BundleTraversalTuning::kMaxPairsPerPacket * counts.n_packets;
    const int n_tests = as_pairs ? counts.n_tests : counts.n_packets;
    count_step(&StepCounters::segments, std::uint64_t(n));
    count_step(&StepCounters::lines, std::uint64_t(n_lines));
    count_step(&StepCounters::packets, std::uint64_t(n_tests));
    cost_ += BundleStepCost::kSegment * std::uint64_t(n) + BundleStepCost::kLine * std::uint64_t(n_lines) +
             BundleStepCost::kPacket * std::uint64_t(n_tests);
  }

  /// Test one packet with one segment at a time.
  template <class Collector>
  Counts test_packets(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n,
                      Collector& collector) {
    Counts counts;
    line_test_.test(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      packets_[counts.n_packets] = first + j;
      counts.n_packets += near != 0;
      if constexpr (Collector::kTraits.order_independent) counts.n_rays += std::popcount(near);
    });
    // Test the packets with rays nearby.
    for (int i = 0; i < counts.n_packets; ++i) {
      const int j = packets_[i] % kSimdWidth, first = packets_[i] - j;
      Fields<P, float> fields;
      for (int k = 0; k < P::kFields; ++k) fields[k] = line_test_.fields[k][j];
      const PacketView packet(rays, first);
      const auto test = P::template test<FloatX16>(packet, fields);
      const auto approach = approach_at(collector.at, test);
      // No branch on whether any ray hits: a misprediction would be found only at the end of a long test.
      const std::uint32_t hit = approach.hit.bits() & lane_mask(std::size_t(rays.n - first));
      collector.add_packet(rays, first, hit, approach, prims[j]);
    }
    return counts;
  }

  /// Test rays with the segments that they may hit, 16 pairs at a time. F is FloatX16; as a template parameter, it
  /// compiles this only for instruction sets that can permute.
  template <class F, class Collector>
  Counts test_pairs(const RayGroup& rays, const RayBundle& bundle, const std::uint32_t* prims, int n,
                    Collector& collector) {
    Counts counts;
    int n_pairs[kGroupSize / kSimdWidth] = {};  // of each packet
    line_test_.test(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      int& n_of_packet = n_pairs[first / kSimdWidth];
      compress_indices(near, std::uint32_t(j * kSimdWidth), pairs_[first / kSimdWidth] + n_of_packet);
      n_of_packet += std::popcount(near);
      counts.n_packets += near != 0;
    });
    for (int first = bundle.first; first < bundle.end; first += kSimdWidth) {
      const std::uint32_t* pair = pairs_[first / kSimdWidth];
      int n_left = n_pairs[first / kSimdWidth];
      counts.n_rays += n_left;
      for (; n_left > 0; n_left -= kSimdWidth, pair += kSimdWidth, ++counts.n_tests) {
        std::uint32_t ray[kSimdWidth], segment[kSimdWidth];
        for (int i = 0; i < kSimdWidth; ++i) {
          ray[i] = pair[i] % kSimdWidth;
          segment[i] = pair[i] / kSimdWidth;
        }
        // Permute rays and segments into lanes, and test them.
        const PermutedRays<F> packet(rays, first, ray);
        Fields<P, F> fields;
        for (int k = 0; k < P::kFields; ++k) fields[k] = F::permute(line_test_.fields[k], segment);
        const auto test = P::template test<F>(packet, fields);
        const auto approach = approach_at(collector.at, test);
        const std::uint32_t hit = approach.hit.bits() & lane_mask(std::size_t(n_left));
        if (hit) collector.add_pairs(first, hit, approach, ray, F::permute(as_floats(prims), segment));
      }
    }
    return counts;
  }

  const WideBvhView<P>& tree_;
  Checkpoint& checkpoint_;
  std::uint64_t cost_ = 0, budget_ = 0;
  TraversalStack stack_;
  VisitedSet visited_;
  BundleLineTest<P> line_test_{};
  int packets_[kSimdWidth * (kGroupSize / kSimdWidth)];  // first lane of a packet + lane of a segment to test with it
  // Pairs of each packet: 16 · lane of the segment + lane of the ray.
  std::uint32_t pairs_[kGroupSize / kSimdWidth][(kSimdWidth + 1) * kSimdWidth] = {};
  std::uint32_t leaves_[kMaxLeaves + kSimdWidth], pieces_[kMaxPieces];
  std::uint32_t prims_[kMaxPieces + kSimdWidth] = {};  // padded with any valid ids: 16 are read
  int n_leaves_ = 0;
  bool use_pairs_ = true;  // from the previous line test
  int n_prims_ = 0;        // buffered, to be tested
};

}  // namespace fastlines
