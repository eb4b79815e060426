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
    stack_.clear();
    stack_.push({0, bundle.axis.t_min});
    while (!stack_.empty() && cost_ <= most) {
      const Waiting next = stack_.pop();
      if (!(next.enter <= deepest)) continue;
      const WideNode& node = tree_.nodes[next.child];
      tally(&Steps::nodes);
      cost_ += TogetherCost::kNode;
      Float16 enter;
      const std::uint32_t lanes = cull_node(bundle.axis, node, deepest, enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      if (lanes != inner) {
        const int n = segments(bundle.axis.across, node.first_leaf - node.n_inner, lanes ^ inner);
        for (int i = 0; i < n; i += kWidth) test(rays, bundle, prims_ + i, std::min(n - i, kWidth), collector);
        if (collector.closer) {
          collector.closer = false;
          deepest = bundle.look(collector.limit);
        }
      }
      stack_.push(node, inner, enter);
    }
    return cost_;
  }

 private:
  /// The segments whose pieces in these leaves survive, but for those that the bundle has met already.
  int segments(const Across& axis, std::uint32_t base, std::uint32_t leaves) {
    int n_pieces = 0, n = 0;
    for (std::uint32_t left = leaves; left; left &= left - 1)
      fetch(tree_.leaves + (base + std::uint32_t(std::countr_zero(left))));
    int n_leaves = 0;
    for (; leaves; leaves &= leaves - 1) {
      leaf_[n_leaves] = tree_.leaves + (base + std::uint32_t(std::countr_zero(leaves)));
      places_[n_leaves] = place_of(*leaf_[n_leaves], axis);
      ++n_leaves;
    }
    tally(&Steps::leaves, std::uint64_t(n_leaves));
    cost_ += TogetherCost::kLeaf * std::uint64_t(n_leaves);
    for (int i = 0; i < n_leaves; ++i) {
      const WideLeaf& leaf = *leaf_[i];
      const std::uint32_t lanes = cull_leaf(axis, leaf, places_[i]);
      pack_numbers(lanes, leaf.first_ref, pieces_ + n_pieces);
      n_pieces += std::popcount(lanes);
    }
    tally(&Steps::pieces, std::uint64_t(n_pieces));
    for (int j = 0; j < n_pieces; ++j) __builtin_prefetch(tree_.refs + pieces_[j]);
    seen_.reserve(std::size_t(n_pieces));
    for (int j = 0; j < n_pieces; ++j) {
      const std::uint32_t prim = tree_.refs[pieces_[j]].prim;
      __builtin_prefetch(tree_.segments + prim);
      prims_[n] = prim;
      n += seen_.insert(prim);
    }
    return n;
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
  const WideLeaf* leaf_[kWidth];
  LeafPlace places_[kWidth];
  std::uint32_t pieces_[(kWidth + 1) * kWidth], prims_[(kWidth + 1) * kWidth];
  Pack packs_[kWidth * (kLanes / kWidth)];
};

}  // namespace fastlines
