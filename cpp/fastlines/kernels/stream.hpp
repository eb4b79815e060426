// All hits of up to 64 rays that have nothing to do with each other. Order does not matter, so nodes are not a stack
// for each ray but one list of (node, ray): long runs of the same test, whose memory can be fetched ahead. Rays come
// past the root sixteen at a time, as in a wave. Leaves that are met wait in a list of their own, and so do pieces that
// survive, in one for each sixteen rays: sixteen pieces at a time are tested exactly, each against its own ray.
#pragma once

#include "choice.hpp"
#include "collect.hpp"
#include "picks.hpp"
#include "root.hpp"
#include "sixteen.hpp"
#include "survivors.hpp"
#include "tally.hpp"

namespace fastlines {

class Stream {
 public:
  explicit Stream(const WideView& tree) : tree_(tree), root_(tree) {}

  /// Make ready for the rays in lanes [first, end), of which the first begins a sixteen.
  void prepare(const RayLanes& rays, int first, int end) {
    for (int i = first; i < end; i += kWidth) {
      const CullOf<Float16> cull = cull_sixteen(rays, i);
      turn(cull, cull_ + i);
      picks_.take(rays, i);
      if (root_.has_inner_only()) pass_root(cull, rays, i);
    }
  }

  /// Show the collector the hits of rays [first, end), each by the piece that owns it; returns what that cost.
  template <class Collector>
  std::uint64_t search(const RayLanes& rays, int first, int end, Collector& collector) {
    cost_ = AloneCost::kRay * std::uint64_t(end - first);
    nodes_.clear();
    leaves_.clear();
    survivors_.clear();
    begin_rays(first, end);
    while (!nodes_.empty()) {
      test_nodes(rays);
      if (leaves_.size() >= kEnough) test_leaves(rays, collector);
    }
    test_leaves(rays, collector);
    for (int i = 0; i < kSixteens; ++i) test_survivors(rays, i, collector);
    return cost_;
  }

 private:
  static constexpr std::size_t kAtOnce = 256, kEnough = 1024, kAhead = 16, kMany = 256;
  static constexpr int kSixteens = kLanes / kWidth;

  /// What sixteen rays meet of the root's children.
  void pass_root(const CullOf<Float16>& cull, const RayLanes& rays, int first) {
    Root::Met met;
    root_.template meet<false>(cull, Float16::load(rays.t_max + first), met);
    for (int i = 0; i < kWidth; ++i) at_root_[first + i] = met.children_of(i);
  }

  /// Rays begin at the root's children, or at the root.
  void begin_rays(int first, int end) {
    const auto n = std::uint64_t(end - first);
    if (!root_.has_inner_only()) {
      for (int i = first; i < end; ++i) nodes_.push(0, std::uint32_t(i));
      return;
    }
    tally(&Steps::nodes, n);
    cost_ += AloneCost::kRoot * n;
    Pairs::Tail nodes = nodes_.tail(n * kWidth);
    for (int i = first; i < end; ++i) nodes.pack(at_root_[i], root_.first_child(), std::uint32_t(i));
    nodes_.end(nodes);
  }

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
    survivors_.add(tree_, leaves_, cull_);
    leaves_.clear();
    for (int i = 0; i < kSixteens; ++i)
      if (survivors_.lists[i].size() >= kMany) test_survivors(rays, i, collector);
  }

  /// Test the pieces that wait for one sixteen of the rays.
  template <class Collector>
  void test_survivors(const RayLanes& rays, int i_sixteen, Collector& collector) {
    Pairs& survivors = survivors_.lists[i_sixteen];
    const std::size_t n = survivors.size();
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const what = survivors.what.data(), *const ray = survivors.ray.data();
    tally(&Steps::pieces, n);
    tally(&Steps::packs, (n + kWidth - 1) / kWidth);
    cost_ += AloneCost::kPack * ((n + kWidth - 1) / kWidth);
    pieces_.reserve(n + kWidth);
    for (std::size_t j = 0; j < n; ++j) {
      const WideRef& ref = tree_.refs[what[j]];
      __builtin_prefetch(tree_.segments + ref.prim);
      pieces_.put(j, ref);
    }
    std::fill_n(pieces_.prim.data() + n, kWidth, 0u);  // sixteen are read
    for (std::size_t j = 0; j < n; j += kWidth) {
      const std::uint32_t* const prims = pieces_.prim.data() + j;
      Float16 start[3], e[3];
      take_sixteen(tree_, [&](int i) { return prims[i]; }, start, e);
      const auto picked = picks_.pick<Float16, kWidth>(rays, i_sixteen * kWidth, ray + j);
      const Seen<Float16> seen = see<Float16>(picked, start, e);
      Approach<Float16> approach = closest_approach(picked, seen);
      float s0[kWidth], s1[kWidth];
      for (std::size_t i = 0; i < kWidth; ++i) {
        s0[i] = WideRef::begin(pieces_.s0[j + i]);
        s1[i] = WideRef::end(pieces_.s1[j + i]);
      }
      const auto owned = (Float16::load(s0) <= approach.s) & (approach.s < Float16::load(s1));
      const std::uint32_t hit = (approach.hit & owned).bits() & first_lanes(n - j);
      if (!hit) continue;
      if constexpr (Collector::kAt == At::surface) approach = entry(picked, seen, approach);
      collector.take_pairs(i_sixteen * kWidth, hit, approach, ray + j, Float16::load(as_floats(prims)));
    }
    survivors.clear();
  }

  /// References, each of their numbers an array.
  struct Pieces {
    std::vector<std::uint32_t> prim;
    std::vector<std::uint16_t> s0, s1;

    void reserve(std::size_t n) {
      if (prim.size() >= n) return;
      prim.resize(2 * n);
      s0.resize(2 * n);
      s1.resize(2 * n);
    }
    void put(std::size_t at, const WideRef& ref) {
      prim[at] = ref.prim;
      s0[at] = ref.s0;
      s1[at] = ref.s1;
    }
  };

  const WideView& tree_;
  std::uint64_t cost_ = 0;
  Root root_;
  CullRay cull_[kLanes];
  std::uint32_t at_root_[kLanes];  // the root's children that a ray meets, as bits
  Picks picks_;
  Pairs nodes_, taken_, leaves_;
  Survivors<kWidth> survivors_;
  Pieces pieces_;
};

}  // namespace fastlines
