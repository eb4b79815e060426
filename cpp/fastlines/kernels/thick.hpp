// The search with a bundle of rays. In phases, none of which waits for a guess of the processor:
//
//   the node's children are culled; inner ones go onto the stack, leaves are culled at once
//   pieces that survive become segments, each once a bundle
//   their lines are seen by all rays from afar
//   where any ray may be in reach, sixteen rays are tested exactly
//
// First hits want what is nearest first, one node at a time. Where all hits are wanted their order does not matter, so
// eight nodes are taken at once, whose memory is waited for together; segments wait until they are sixteen; and pairs
// of a ray and a segment, most of sixteen rays being far from most segments, are tested sixteen at a time.
//
// What is in reach goes to a collector (collect.hpp), which also tells each ray's limit.
#pragma once

#include <utility>

#include "../query/visited_set.hpp"
#include "beside.hpp"
#include "choice.hpp"
#include "collect.hpp"
#include "fetch.hpp"
#include "picks.hpp"
#include "stack.hpp"

namespace fastlines {

class ThickSearch {
 public:
  explicit ThickSearch(const WideView& tree) : tree_(tree) {}

  /// Show the collector what the rays of a bundle come near; returns what that cost. What costs more than `most` is
  /// given up.
  template <class Collector>
  std::uint64_t search(const RayLanes& rays, Bundle& bundle, Collector& collector, std::uint64_t most) {
    tally(&Steps::bundles);
    cost_ = TogetherCost::kRay * std::uint64_t(bundle.end - bundle.first);
    most_ = most;
    float deepest = bundle.look(collector.limit);
    visited_.clear();
    n_prims_ = 0;
    stack_.clear();
    stack_.push({0, bundle.axis.t_min});
    while (!stack_.empty() && cost_ <= most) {
      nodes<Collector::kUnordered ? kAtOnce : 1>(bundle.axis, deepest);
      if (n_leaves_ == 0) continue;
      segments(bundle.axis.across);
      test_all(rays, bundle, Collector::kUnordered ? kWidth : 1, collector);
      if (collector.closer) {
        collector.closer = false;
        if constexpr (requires { collector.bring_limits(rays, 0, 0); })
          collector.bring_limits(rays, bundle.first, bundle.end);
        deepest = bundle.look(collector.limit);
      }
    }
    test_all(rays, bundle, 1, collector);
    return cost_;
  }

 private:
  static constexpr int kAtOnce = 8, kLeaves = kAtOnce * kWidth, kPieces = (kLeaves + 1) * kWidth;
  static constexpr int kMany = 13;  // of sixteen rays near a segment: beyond it, to pick pairs costs more than it saves

  /// What was seen from afar: packs with any ray near, where order does not matter rays near in all of them, and tests
  /// of sixteen pairs of these.
  struct Near {
    int n_packs = 0, n_rays = 0, n_tests = 0;
  };

  /// Take up to n nodes from the stack, and list those of their children that are leaves.
  template <int n>
  void nodes(const CullRay& axis, float deepest) {
    Waiting next[n];
    int n_next = 0;
    while (n_next < n && !stack_.empty()) {
      next[n_next] = stack_.pop();
      n_next += next[n_next].enter <= deepest;
    }
    tally(&Steps::nodes, std::uint64_t(n_next));
    cost_ += TogetherCost::kNode * std::uint64_t(n_next);
    int n_leaves = 0;  // in a register: a count in memory would be waited for
    for (int i = 0; i < n_next; ++i) {
      const WideNode& node = tree_.nodes[next[i].node];
      Float16 enter;
      const std::uint32_t lanes = cull_node(axis, node, deepest, enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      pack_numbers(lanes ^ inner, node.first_leaf - node.n_inner, leaves_ + n_leaves);
      n_leaves += std::popcount(lanes ^ inner);
      stack_.push(node, inner, enter);
    }
    n_leaves_ = n_leaves;
    if (!stack_.empty()) fetch(tree_.nodes + stack_.top().node);
    for (int i = 0; i < n_leaves; ++i) fetch(tree_.leaves + leaves_[i]);
  }

  /// Append the segments whose pieces in these leaves survive, but for those that the bundle has met already.
  void segments(const Across& axis) {
    // Where the next leaf lies is found before this one is tested; beyond the last any will do. The references of most
    // leaves will be wanted.
    leaves_[n_leaves_] = leaves_[0];
    LeafPlace next = place_of(tree_.leaves[leaves_[0]], axis);
    int n_pieces = 0;
    const WideView tree = tree_;  // a copy, so that nothing written can alias it
    for (int i = 0, n = n_leaves_; i < n; ++i) {
      const WideLeaf& leaf = tree.leaves[leaves_[i]];
      const LeafPlace place = std::exchange(next, place_of(tree.leaves[leaves_[i + 1]], axis));
      fetch_refs(tree, leaf);
      const std::uint32_t lanes = cull_leaf(axis, leaf, place);
      pack_numbers(lanes, leaf.first_ref, pieces_ + n_pieces);
      n_pieces += std::popcount(lanes);
    }
    tally(&Steps::leaves, std::uint64_t(n_leaves_));
    tally(&Steps::pieces, std::uint64_t(n_pieces));
    cost_ += TogetherCost::kLeaf * std::uint64_t(n_leaves_);
    visited_.reserve(std::size_t(n_pieces));
    int n_prims = n_prims_;
    for (int j = 0; j < n_pieces; ++j) {
      const std::uint32_t prim = tree.refs[pieces_[j]].prim;
      __builtin_prefetch(tree.segments + prim);
      prims_[n_prims] = prim;
      n_prims += visited_.insert(prim);
    }
    n_prims_ = n_prims;
  }

  /// Test the segments that wait, sixteen at a time, as long as there are so many.
  template <class Collector>
  void test_all(const RayLanes& rays, const Bundle& bundle, int at_least, Collector& collector) {
    int i = 0;
    for (; n_prims_ - i >= at_least && cost_ <= most_; i += kWidth)
      test(rays, bundle, prims_ + i, std::min(n_prims_ - i, kWidth), collector);
    if (i == 0) return;
    n_prims_ = std::max(n_prims_ - i, 0);
    std::copy_n(prims_ + i, n_prims_, prims_);
  }

  template <class Collector>
  void test(const RayLanes& rays, const Bundle& bundle, const std::uint32_t* prims, int n, Collector& collector) {
    lines_.take(tree_, prims, bundle);
    const int n_lines = n * (bundle.end - bundle.first) / kWidth;
    Near near;
    bool as_pairs = false;
    if constexpr (Collector::kUnordered && Float16::kLooksUp > 0) {
      as_pairs = few_near_;
      if (as_pairs) near = test_pairs<Float16>(rays, bundle, prims, n, collector);
    }
    if (!as_pairs) near = test_packs(rays, bundle, prims, n, collector);
    few_near_ = near.n_rays <= kMany * near.n_packs;
    const int n_tests = as_pairs ? near.n_tests : near.n_packs;
    tally(&Steps::segments, std::uint64_t(n));
    tally(&Steps::lines, std::uint64_t(n_lines));
    tally(&Steps::packs, std::uint64_t(n_tests));
    cost_ += TogetherCost::kSegment * std::uint64_t(n) + TogetherCost::kLine * std::uint64_t(n_lines) +
             TogetherCost::kPack * std::uint64_t(n_tests);
  }

  /// Test sixteen rays beside one segment at a time.
  template <class Collector>
  Near test_packs(const RayLanes& rays, const Bundle& bundle, const std::uint32_t* prims, int n, Collector& collector) {
    Near seen;
    lines_.look(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      packs_[seen.n_packs] = first + j;
      seen.n_packs += near != 0;
      if constexpr (Collector::kUnordered) seen.n_rays += std::popcount(near);
    });
    for (int i = 0; i < seen.n_packs; ++i) {
      const int j = packs_[i] % kWidth, first = packs_[i] - j;
      const Vec3 start{lines_.start[0][j], lines_.start[1][j], lines_.start[2][j]};
      const Vec3 along{lines_.along[0][j], lines_.along[1][j], lines_.along[2][j]};
      const Rays16 sixteen(rays, first);
      const Seen<Float16> g = see<Float16>(sixteen, start, along);
      Approach<Float16> approach = closest_approach(sixteen, g);
      if constexpr (Collector::kAt == At::surface) approach = entry(sixteen, g, approach);
      // Without asking first whether any hits: the guess would be known to be wrong only at the end of a long test.
      const std::uint32_t hit = approach.hit.bits() & first_lanes(std::size_t(rays.n - first));
      collector.take(rays, first, hit, approach, prims[j]);
    }
    return seen;
  }

  /// Test rays beside the segments that each may come near, sixteen pairs at a time. F is Float16: named, so that this
  /// is compiled only where it can look up.
  template <class F, class Collector>
  Near test_pairs(const RayLanes& rays, const Bundle& bundle, const std::uint32_t* prims, int n, Collector& collector) {
    Near seen;
    int n_pairs[kLanes / kWidth] = {};  // of each sixteen rays
    lines_.look(bundle, n, [&](int j, int first, std::uint32_t near) __attribute__((always_inline)) {
      int& n_here = n_pairs[first / kWidth];
      pack_numbers(near, std::uint32_t(j * kWidth), pairs_[first / kWidth] + n_here);
      n_here += std::popcount(near);
      seen.n_packs += near != 0;
    });
    for (int first = bundle.first; first < bundle.end; first += kWidth) {
      const std::uint32_t* pair = pairs_[first / kWidth];
      int left = n_pairs[first / kWidth];
      seen.n_rays += left;
      for (; left > 0; left -= kWidth, pair += kWidth, ++seen.n_tests) {
        std::uint32_t ray[kWidth], segment[kWidth];
        for (int i = 0; i < kWidth; ++i) {
          ray[i] = pair[i] % kWidth;
          segment[i] = pair[i] / kWidth;
        }
        const ChosenRays<F> sixteen(rays, first, ray);
        F start[3], along[3];
        for (int k = 0; k < 3; ++k) {
          start[k] = F::look_up(lines_.start[k], segment);
          along[k] = F::look_up(lines_.along[k], segment);
        }
        const Seen<F> g = see<F>(sixteen, start, along);
        Approach<F> approach = closest_approach(sixteen, g);
        if constexpr (Collector::kAt == At::surface) approach = entry(sixteen, g, approach);
        const std::uint32_t hit = approach.hit.bits() & first_lanes(std::size_t(left));
        if (hit) collector.take_pairs(first, hit, approach, ray, F::look_up(as_floats(prims), segment));
      }
    }
    return seen;
  }

  const WideView& tree_;
  std::uint64_t cost_ = 0, most_ = 0;
  Stack stack_;
  VisitedSet visited_;
  LinesBeside lines_{};
  int packs_[kWidth * (kLanes / kWidth)];  // the first of sixteen rays, plus the segment they are tested beside
  // Pairs, a list for each sixteen rays: sixteen times the segment, plus the ray.
  std::uint32_t pairs_[kLanes / kWidth][(kWidth + 1) * kWidth] = {};
  std::uint32_t leaves_[kLeaves + kWidth], pieces_[kPieces];
  std::uint32_t prims_[kPieces + kWidth] = {};  // past the last stand any others: sixteen are read
  int n_leaves_ = 0;
  bool few_near_ = true;  // of the lines seen last
  int n_prims_ = 0;       // that wait to be tested
};

}  // namespace fastlines
