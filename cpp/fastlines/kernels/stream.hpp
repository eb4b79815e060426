// All hits of up to 64 rays that have nothing to do with each other. Order does not matter, so nodes are not a stack
// for each ray but one list of (node, ray): long runs of the same test, whose memory can be fetched ahead. Leaves that
// are met wait in a list of their own, and so do pieces that survive; these are sorted by ray, and each ray is tested
// exactly against sixteen segments at a time.
#pragma once

#include "choice.hpp"
#include "collect.hpp"
#include "cull.hpp"
#include "fetch.hpp"
#include "pairs.hpp"
#include "sixteen.hpp"
#include "tally.hpp"

namespace fastlines {

class Stream {
 public:
  explicit Stream(const WideView& tree) : tree_(tree) {}

  /// Show the collector the hits of rays [first, end), each by the piece that owns it; returns what that cost.
  template <class Collector>
  std::uint64_t search(const RayLanes& rays, int first, int end, Collector& collector) {
    first_ = first;
    end_ = end;
    cost_ = AloneCost::kRay * std::uint64_t(end - first);
    nodes_.clear();
    leaves_.clear();
    survivors_.clear();
    for (int i = first; i < end; ++i) {
      cull_[i] = CullRay(rays.ray(i));
      nodes_.push(0, std::uint32_t(i));
    }
    while (!nodes_.empty()) {
      test_nodes(rays);
      if (leaves_.size() >= kEnough) test_leaves(rays, collector);
    }
    test_leaves(rays, collector);
    test_survivors(rays, collector);
    return cost_;
  }

 private:
  static constexpr std::size_t kAtOnce = 256, kEnough = 1024, kSome = 128, kAhead = 16;

  /// Take some pairs from the end of the list, so that it stays short, and test them.
  void test_nodes(const RayLanes& rays) {
    const std::size_t n = std::min(nodes_.size(), kAtOnce), begin = nodes_.size() - n;
    taken_.what.assign(nodes_.what.begin() + std::ptrdiff_t(begin), nodes_.what.begin() + std::ptrdiff_t(begin + n));
    taken_.ray.assign(nodes_.ray.begin() + std::ptrdiff_t(begin), nodes_.ray.begin() + std::ptrdiff_t(begin + n));
    nodes_.n = begin;
    tally(&Steps::nodes, n);
    cost_ += AloneCost::kNode * n;
    Pairs::Tail nodes = nodes_.tail(n * kWidth), leaves = leaves_.tail(n * kWidth);
    const WideNode* const tree_nodes = tree_.nodes;
    for (std::size_t j = 0; j < n; ++j) {
      if (j + kAhead < n) fetch(tree_nodes + taken_.what[j + kAhead]);
      const WideNode& node = tree_nodes[taken_.what[j]];
      const std::uint32_t ray = taken_.ray[j];
      Float16 near;
      const std::uint32_t lanes = cull_node(cull_[ray], node, rays.t_max[ray], near);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      nodes.pack(inner, node.first_inner, ray);
      leaves.pack(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    }
    nodes_.end(nodes);
    leaves_.end(leaves);
  }

  template <class Collector>
  void test_leaves(const RayLanes& rays, Collector& collector) {
    const std::size_t n = leaves_.size();
    tally(&Steps::leaves, n);
    cost_ += AloneCost::kLeaf * n;
    Pairs::Tail survivors = survivors_.tail(n * kWidth);
    const WideLeaf* const leaves = tree_.leaves;
    for (std::size_t j = 0; j < std::min(n, kAhead); ++j) fetch(leaves + leaves_.what[j]);
    for (std::size_t first = 0; first < n; first += kSome) {
      const std::uint32_t *const what = leaves_.what.data() + first, *const ray = leaves_.ray.data() + first;
      const std::size_t left = n - first, some = std::min(left, kSome);
      for (std::size_t begin = 0; begin < some; begin += kAhead) {
        const std::size_t end = std::min(begin + kAhead, some);
        for (std::size_t j = begin; j < end; ++j) places_[j - begin] = place_of(leaves[what[j]], cull_[ray[j]].across);
        for (std::size_t j = begin; j < end; ++j) {
          if (j + kAhead < left) fetch(leaves + what[j + kAhead]);
          near_[j] = cull_leaf(cull_[ray[j]].across, leaves[what[j]], places_[j - begin]);
        }
      }
      for (std::size_t i = 0, n_met = pack_set(near_, some, met_); i < n_met; ++i) {
        const std::uint32_t j = met_[i];
        survivors.pack(near_[j], leaves[what[j]].first_ref, ray[j]);
      }
    }
    survivors_.end(survivors);
    leaves_.clear();
    if (survivors_.size() >= kEnough) test_survivors(rays, collector);
  }

  template <class Collector>
  void test_survivors(const RayLanes& rays, Collector& collector) {
    // Sort by ray; begin[i] becomes where ray i's are.
    const std::size_t n = survivors_.size();
    tally(&Steps::pieces, n);
    std::uint32_t begin[kLanes + 1], next[kLanes];
    std::fill(begin + first_, begin + end_ + 1, 0u);
    for (std::size_t j = 0; j < n; ++j) {
      __builtin_prefetch(tree_.refs + survivors_.what[j]);
      ++begin[survivors_.ray[j] + 1];
    }
    for (int i = first_; i < end_; ++i) {
      next[i] = begin[i];
      begin[i + 1] += begin[i];
    }
    if (sorted_.size() < n + kWidth) sorted_.resize(2 * (n + kWidth));
    std::fill_n(sorted_.data() + n, kWidth, survivors_.what[0]);  // sixteen are read, from wherever the last begin
    for (std::size_t j = 0; j < n; ++j) {
      const Reference& ref = tree_.refs[survivors_.what[j]];
      __builtin_prefetch(tree_.segments + ref.prim);
      sorted_[next[survivors_.ray[j]]++] = survivors_.what[j];
    }
    survivors_.clear();

    for (int i = first_; i < end_; ++i)
      if (begin[i] != begin[i + 1]) test_ray(rays.ray(i), i, begin[i], begin[i + 1], collector);
  }

  /// Test one ray against the segments of sorted_[begin … end), sixteen at a time.
  template <class Collector>
  void test_ray(const Ray& ray, int lane, std::size_t begin, std::size_t end, Collector& collector) {
    alignas(64) float s0[kWidth], s1[kWidth];
    std::uint32_t prims[kWidth];
    for (; begin < end; begin += kWidth) {
      const int n = int(std::min<std::size_t>(end - begin, kWidth));
      tally(&Steps::packs);
      cost_ += AloneCost::kPack;
      for (int j = 0; j < kWidth; ++j) {
        const Reference& ref = tree_.refs[sorted_[begin + std::size_t(j)]];
        s0[j] = ref.s0;
        s1[j] = ref.s1;
        prims[j] = ref.prim;
      }
      Float16 start[3], e[3];
      take_sixteen(tree_, [&](int j) { return prims[j]; }, start, e);
      const Approach<Float16> approach = closest_approach(ray, see<Float16>(ray, start, e));
      const Mask16 owned = (Float16::load(s0) <= approach.s) & (approach.s < Float16::load(s1));
      const std::uint32_t hit = (approach.hit & owned).bits() & ((1u << n) - 1);
      if (hit) collector.take_of_ray(lane, hit, approach, prims);
    }
  }

  const WideView& tree_;
  int first_ = 0, end_ = 0;
  std::uint64_t cost_ = 0;
  CullRay cull_[kLanes];
  LeafPlace places_[kAhead];                // of some leaves
  std::uint32_t near_[kSome], met_[kSome];  // the pieces of each that survive; those of which any does
  Pairs nodes_, taken_, leaves_, survivors_;
  std::vector<std::uint32_t> sorted_;
};

}  // namespace fastlines
