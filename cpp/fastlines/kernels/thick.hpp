// The search with a bundle of rays. Node by node, in phases, none of which waits for a guess of the processor:
//
//   the node's children are culled; inner ones go onto the stack, leaves are culled at once
//   pieces that survive become segments, each once a bundle
//   their lines are seen by all rays from afar
//   where any ray may be in reach, sixteen rays are tested exactly
//
// What is in reach goes to a collector (collect.hpp), which also tells each ray's limit.
#pragma once

#include "beside.hpp"
#include "choice.hpp"
#include "collect.hpp"
#include "fetch.hpp"
#include "seen_set.hpp"
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
    float deepest = bundle.look(collector.limit);
    seen_.clear();
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
        deepest = bundle.look(collector.limit);
      }
    }
    test_all(rays, bundle, 1, collector);
    return cost_;
  }

 private:
  static constexpr int kAtOnce = 8, kLeaves = kAtOnce * kWidth, kPieces = (kLeaves + 1) * kWidth;

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
    n_leaves_ = 0;
    for (int i = 0; i < n_next; ++i) {
      const WideNode& node = tree_.nodes[next[i].child];
      Float16 enter;
      const std::uint32_t lanes = cull_node(axis, node, deepest, enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      pack_numbers(lanes ^ inner, node.first_leaf - node.n_inner, leaves_ + n_leaves_);
      n_leaves_ += std::popcount(lanes ^ inner);
      stack_.push(node, inner, enter);
    }
    if (!stack_.empty()) fetch(tree_.nodes + stack_.top().child);
    for (int i = 0; i < n_leaves_; ++i) fetch(tree_.leaves + leaves_[i]);
  }

  /// Append the segments whose pieces in these leaves survive, but for those that the bundle has met already.
  void segments(const Across& axis) {
    for (int i = 0; i < n_leaves_; ++i) places_[i] = place_of(tree_.leaves[leaves_[i]], axis);
    int n_pieces = 0;
    for (int i = 0; i < n_leaves_; ++i) {
      const WideLeaf& leaf = tree_.leaves[leaves_[i]];
      const std::uint32_t lanes = cull_leaf(axis, leaf, places_[i]);
      pack_numbers(lanes, leaf.first_ref, pieces_ + n_pieces);
      n_pieces += std::popcount(lanes);
    }
    tally(&Steps::leaves, std::uint64_t(n_leaves_));
    tally(&Steps::pieces, std::uint64_t(n_pieces));
    cost_ += TogetherCost::kLeaf * std::uint64_t(n_leaves_);
    for (int j = 0; j < n_pieces; ++j) __builtin_prefetch(tree_.refs + pieces_[j]);
    seen_.reserve(std::size_t(n_pieces));
    for (int j = 0; j < n_pieces; ++j) {
      const std::uint32_t prim = tree_.refs[pieces_[j]].prim;
      __builtin_prefetch(tree_.segments + prim);
      prims_[n_prims_] = prim;
      n_prims_ += seen_.insert(prim);
    }
  }

  /// Test the segments that wait, sixteen at a time, as long as there are so many.
  template <class Collector>
  void test_all(const RayLanes& rays, const Bundle& bundle, int at_least, Collector& collector) {
    int i = 0;
    for (; n_prims_ - i >= at_least; i += kWidth) test(rays, bundle, prims_ + i, std::min(n_prims_ - i, kWidth), collector);
    if (i == 0) return;
    n_prims_ = std::max(n_prims_ - i, 0);
    std::copy_n(prims_ + i, n_prims_, prims_);
  }

  template <class Collector>
  void test(const RayLanes& rays, const Bundle& bundle, const std::uint32_t* prims, int n, Collector& collector) {
    lines_.take(tree_, prims, n, bundle);
    tally(&Steps::segments, std::uint64_t(n));
    int n_packs = 0;
    for (int j = 0; j < n; ++j)
      for (int first = bundle.first; first < bundle.end; first += kWidth) {
        const std::uint32_t near = lines_.near(bundle, first, j);
        packs_[n_packs] = {j, first, near};
        n_packs += near != 0;
      }
    tally(&Steps::lines, std::uint64_t(n * (bundle.end - bundle.first) / kWidth));
    tally(&Steps::packs, std::uint64_t(n_packs));
    cost_ += TogetherCost::kSegment * std::uint64_t(n) +
             TogetherCost::kLine * std::uint64_t(n * (bundle.end - bundle.first) / kWidth) +
             TogetherCost::kPack * std::uint64_t(n_packs);
    for (int i = 0; i < n_packs; ++i) {
      const auto [j, first, near] = packs_[i];
      const Vec3 start{lines_.start[0][j], lines_.start[1][j], lines_.start[2][j]};
      const Vec3 along{lines_.along[0][j], lines_.along[1][j], lines_.along[2][j]};
      const Rays16 sixteen(rays, first);
      const Approach<Float16> approach = closest_approach(sixteen, see<Float16>(sixteen, start, along));
      const std::uint32_t hit = approach.hit.bits() & near;
      if (hit) collector.take(rays, first, hit, approach, prims[j]);
    }
  }

  /// Sixteen rays beside a segment, some of which may be in reach.
  struct Pack {
    int segment, first;
    std::uint32_t near;
  };

  const WideView& tree_;
  std::uint64_t cost_ = 0;
  Stack stack_;
  SeenSet seen_;
  LinesBeside lines_{};
  Pack packs_[kWidth * (kLanes / kWidth)];
  LeafPlace places_[kLeaves];
  std::uint32_t leaves_[kLeaves + kWidth], pieces_[kPieces], prims_[kPieces + kWidth];
  int n_leaves_ = 0;
  int n_prims_ = 0;  // that wait to be tested
};

}  // namespace fastlines
