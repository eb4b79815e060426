// Traces up to 64 incoherent rays as a wavefront. Each ray has a stack of its own; all take a step together, in phases:
//
//   A  nodes        cull each ray's node: leaf children go to a work list, inner ones to the ray's stack
//   B  leaves       cull each leaf of the list: surviving pieces go to a second work list
//   C  exact tests  test the survivors, 16 at a time, each against its own ray
//   D  next nodes   each ray takes its nearest waiting child, or ends
//
// If hits do not shrink the limit, any waiting child will do, and phase A has already taken it. Rays pass the root in
// packets of 16 when they enter (root_cull.hpp).
//
// A ray traced alone mostly waits for memory and mispredicted branches. In a wavefront no ray waits for the step of
// another, each phase prefetches what the next one reads, and work lists are compressed without branches.
//
// Rays enter and leave in packets of 16, each in its lane. A set of lanes holds the active rays.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "../../parallel/progress.hpp"
#include "../collect/collector.hpp"
#include "../cost/step_cost.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/load_fields.hpp"
#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"
#include "../intersect/root_cull.hpp"
#include "../rays/spread_rays.hpp"
#include "lane_set.hpp"
#include "leaf_survivors.hpp"
#include "pending_hits.hpp"
#include "wavefront_stacks.hpp"
#include "work_list.hpp"

namespace fastlines {

template <RayPrimitive P, class Query>
class Wavefront {
 public:
  Wavefront(const WideBvhView<P>& tree, const Query& query, Checkpoint& checkpoint)
      : tree_(tree), checkpoint_(checkpoint), root_(tree), collector_(query.collector()) {}

  /// Enter the rays in lanes [first, end) of the packet that begins at `first`. Takes steps until a packet is free; the
  /// query stores the answers of packets that end.
  void add(const RayGroupOf<P>& rays, int first, int end, Query& query) {
    // Find a free packet.
    int packet = 0;
    while (n_left_[packet] > 0)
      if (++packet == kPackets) {
        step(query);
        packet = 0;
      }
    // Copy and prepare the rays.
    const int to = packet * kSimdWidth, n = end - first;
    rays_.template copy<Collector::kTraits.needs_position>(to, rays, first);
    collector_.begin(rays_, to, to + n);
    gather_.load(rays_, to);
    n_left_[packet] = n_in_[packet] = n;
    cost_ += SingleStepCost::kRay * std::uint64_t(n);
    n_half_rays_ += std::uint64_t(n);
    const CullRayOf<FloatX16> cull = cull_packet(rays, first);
    transpose(cull, cull_ + to);
    // Start at the root's children, or at the root.
    if (root_.has_inner_only()) {
      pass_root(cull, to, n, query);
    } else {
      std::fill_n(node_ + to, n, 0u);
      std::iota(top_ + to, top_ + to + n, to);
      active_ |= lane_range(to, n);
    }
  }

  /// Cost and number of rays since the last call, or nothing if no ray has ended since. A ray counts half when it
  /// enters and half when it ends, so that active rays do not inflate the cost per ray.
  Sample take_sample() {
    if (!std::exchange(any_ended_, false)) return {};
    const Sample sample{std::exchange(cost_, 0), n_half_rays_ / 2};
    n_half_rays_ %= 2;
    return sample;
  }

  /// Finish all rays.
  void flush(Query& query) {
    while (active_) step(query);
  }

 private:
  using Collector = typename Query::Collector;
  static constexpr bool kShrinksLimit = Collector::kTraits.shrinks_limit;
  using Stacks = WavefrontStacks<kShrinksLimit>;
  static constexpr std::int32_t kStride = Stacks::kStride;
  static std::int32_t stride_if(bool is) { return Stacks::stride_if(is); }
  static constexpr int kPackets = kGroupSize / kSimdWidth;
  static constexpr std::uint64_t kLowerHalf = 0xffff'ffff;  // of the lanes

  /// The first step of the n rays of the packet that begins at lane `first`, all at once.
  void pass_root(const CullRayOf<FloatX16>& cull, int first, int n, Query& query) {
    cost_ += SingleStepCost::kRoot * std::uint64_t(n);
    count_step(&StepCounters::nodes, std::uint64_t(n));
    RootCull::Hits root_hits;
    root_.template cull<kShrinksLimit>(cull, FloatX16::load(collector_.limit + first), root_hits);
    // Push the root's children, and take the first of them.
    const auto stacks = stacks_.view();
    const std::int32_t above = first + kStride;
    if constexpr (kShrinksLimit)
      transpose_columns<kSimdWidth>([&](int child) { return root_hits.enter[child]; }, stacks.distances + above);
    const std::uint32_t first_child = root_.first_child();
    std::uint64_t entered = 0;
    for (int i = 0; i < kSimdWidth; ++i) {
      const std::uint32_t children = root_hits.children_of(i);
      const auto next = kShrinksLimit ? std::uint32_t(std::int32_t(root_hits.nearest[i]))
                                      : std::uint32_t(std::countr_zero(children | 1u << kSimdWidth));
      const std::uint32_t waiting = children & ~(1u << next);
      node_[first + i] = first_child + next;
      stacks.entries[above + i] = {first_child, waiting};
      top_[first + i] = first + i + stride_if(waiting != 0);
      entered |= std::uint64_t(children != 0) << (first + i);
    }
    entered &= lane_range(first, n);
    active_ |= entered;
    for_each_lane(entered, [&](std::uint32_t ray) { prefetch(tree_.nodes + node_[ray]); });
    for_each_lane(lane_range(first, n) & ~entered, [&](std::uint32_t ray) { end_ray(ray, query); });
  }

  void step(Query& query) {
    stacks_.prepare_step(active_, top_);
    test_nodes();
    survivors_.clear();
    survivors_.add(tree_, leaves_, cull_);
    WorkList& survivors = survivors_.lists[0];
    list_prims(survivors);
    // Search for the nearest children in two halves. The first half overlaps with the prefetch of primitives, the
    // second with the exact tests, whose results a mispredicted branch would have to wait for.
    if constexpr (kShrinksLimit) find_nearest(active_ & kLowerHalf);
    test_survivors(survivors);
    if constexpr (kShrinksLimit) find_nearest(active_ & ~kLowerHalf);
    flush_hits();
    const auto n_active = std::uint64_t(std::popcount(active_));
    cost_ += SingleStepCost::kNode * n_active + SingleStepCost::kLeaf * leaves_.size();
    checkpoint_.pass(leaves_.size());
    count_step(&StepCounters::nodes, n_active);
    count_step(&StepCounters::leaves, leaves_.size());
    const std::uint64_t before = active_;
    if constexpr (kShrinksLimit)
      take_nearest();
    else
      drop_finished();
    for_each_lane(before & ~active_, [&](std::uint32_t ray) { end_ray(ray, query); });
  }

  /// Phase A.
  void test_nodes() {
    const WideNode* const nodes = tree_.nodes;
    const auto stacks = stacks_.view();
    leaves_.clear();
    WorkList::Appender leaves = leaves_.appender(std::size_t(std::popcount(active_)) * kSimdWidth);
    for_each_lane(active_, [&](std::uint32_t ray) __attribute__((always_inline)) {
      // Cull the node.
      const WideNode& node = nodes[node_[ray]];
      FloatX16 enter;
      const std::uint32_t lanes = cull_node(cull_[ray], node, collector_.limit[ray], enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      // Push its inner children; without any, the entry is written but stays above the top.
      const std::int32_t above = top_[ray] + kStride;
      std::int32_t top = top_[ray] + stride_if(inner != 0);
      stacks.entries[above] = {node.first_inner, inner};
      if constexpr (kShrinksLimit) {
        enter.store(stacks.distances[above].of);
      } else {
        // Take any waiting child.
        typename Stacks::Entry& entry = stacks.entries[top];
        node_[ray] = entry.first_child + std::uint32_t(std::countr_zero(entry.waiting));
        entry.waiting &= entry.waiting - 1;
        top -= stride_if(entry.waiting == 0);
        prefetch(nodes + node_[ray]);  // an arbitrary node if no child waits; the ray then ends
      }
      top_[ray] = top;
      leaves.compress(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    });
    leaves_.commit(leaves);
  }

  /// List and prefetch the primitives of the survivors, and pad the list with 16 times primitive 0, because whole
  /// packets are read.
  void list_prims(const WorkList& survivors) {
    const WideBvhView<P> tree = tree_;
    const std::size_t n = survivors.size();
    if (prims_.size() < n + kSimdWidth) prims_.resize(2 * (n + kSimdWidth));
    std::uint32_t* const to = prims_.data();
    for (std::size_t j = 0; j < n; ++j) {
      to[j] = tree.refs[survivors.item[j]].prim;
      __builtin_prefetch(tree.items + to[j]);
    }
    std::fill_n(to + n, kSimdWidth, 0u);
  }

  /// Phase C.
  void test_survivors(WorkList& survivors) {
    const std::size_t n = survivors.size();
    cost_ += SingleStepCost::kTest * n;
    count_step(&StepCounters::pieces, n);
    count_step(&StepCounters::packets, (n + kSimdWidth - 1) / kSimdWidth);
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const refs = survivors.item.data(), *const ray = survivors.ray.data();
    for (std::size_t j = 0; j < n; j += kSimdWidth) {
      if (pending_.is_full()) flush_hits();
      test_packet(refs + j, prims_.data() + j, ray + j, std::min<std::size_t>(n - j, kSimdWidth));
    }
  }

  /// Test n survivors, at most 16. `flush_hits` reports the hits.
  [[gnu::always_inline]] void test_packet(const std::uint32_t* refs, const std::uint32_t* prims,
                                          const std::uint32_t* ray, std::size_t n) {
    const auto fields = load_fields(tree_, [=](int i) { return prims[i]; });
    const auto rays = gather_.template gather<FloatX16, kGroupSize>(rays_, 0, ray);
    const auto test = P::template test<FloatX16>(rays, fields);
    const auto approach = approach_at(collector_.at, test);
    pending_.add(refs, ray, rays.tie_tolerance, approach, approach.hit.bits() & lane_mask(n));
  }

  void flush_hits() { pending_.flush(tree_.refs, rays_, collector_); }

  /// Phase D if hits shrink the limit: each ray takes the child that `find_nearest` has found. If that child is beyond
  /// the limit, all of its entry is: pop the entry and search the one below. All such rays do so together, so that no
  /// branch depends on which they are.
  void take_nearest() {
    std::uint64_t candidates = std::exchange(active_, 0);
    while (candidates) {
      std::uint64_t beyond = 0;
      for_each_lane(candidates, [&](std::uint32_t ray) __attribute__((always_inline)) {
        const bool is_within = enter_[ray] <= collector_.limit[ray];
        top_[ray] -= stride_if(!is_within) | pop_stride_[ray];
        beyond |= std::uint64_t(!is_within) << ray;
      });
      active_ |= candidates & ~beyond;
      candidates = 0;
      for_each_lane(beyond, [&](std::uint32_t ray) { candidates |= std::uint64_t(top_[ray] >= kStride) << ray; });
      find_nearest(candidates);
    }
    for_each_lane(active_, [&](std::uint32_t ray) { prefetch(tree_.nodes + node_[ray]); });
  }

  /// Find the nearest waiting child of the topmost entry of each of these rays, and remove it from the entry.
  void find_nearest(std::uint64_t lanes) {
    const auto stacks = stacks_.view();
    for_each_lane(lanes, [&](std::uint32_t ray) __attribute__((always_inline)) {
      typename Stacks::Entry& entry = stacks.entries[top_[ray]];
      const FloatX16 enter = blend(entry.waiting, FloatX16::load(stacks.distances[top_[ray]].of), kInfinity);
      const float first = reduce_min(enter);
      const auto child = std::uint32_t(std::countr_zero((enter <= FloatX16(first)).bits()));
      enter_[ray] = first;
      node_[ray] = entry.first_child + child;
      entry.waiting &= ~(1u << child);
      pop_stride_[ray] = stride_if(entry.waiting == 0);
    });
  }

  /// Phase D otherwise: rays that have a node and need more hits stay active. Below level 0, `top_` is negative: as a
  /// float it is negative or NaN. Lanes without a ray may hold anything. Vector loads after scalar stores do not stall
  /// here: `top_` was written long before, and limits rarely change.
  void drop_finished() {
    active_ &= lanes_where([&](int first) {
      const FloatX16 top = FloatX16::load(reinterpret_cast<const float*>(top_ + first));
      return (FloatX16(0.0f) <= top) & (FloatX16(kNoMoreHits) < FloatX16::load(collector_.limit + first));
    });
  }

  void end_ray(std::uint32_t ray, Query& query) {
    ++n_half_rays_;
    any_ended_ = true;
    const int packet = int(ray) / kSimdWidth;
    if (--n_left_[packet] == 0)
      query.store(rays_, collector_, packet * kSimdWidth, packet * kSimdWidth + n_in_[packet]);
  }

  const WideBvhView<P>& tree_;
  Checkpoint& checkpoint_;
  RootCull root_;
  RayGroupOf<P> rays_;
  Collector collector_;
  CullRay cull_[kGroupSize];
  RayGatherOf<P> gather_;
  std::uint64_t active_ = 0;                         // the lanes of rays that have not ended
  std::uint32_t node_[kGroupSize];                   // the next node of each ray
  alignas(64) std::int32_t top_[kGroupSize] = {};    // the index of the uppermost entry of each stack
  int n_in_[kPackets] = {}, n_left_[kPackets] = {};  // the rays of each packet: all, and those that have not ended
  Stacks stacks_;

  // Data that one phase hands to another.
  WorkList leaves_;
  LeafSurvivors<kGroupSize> survivors_;
  std::vector<std::uint32_t> prims_;     // of the survivors
  float enter_[kGroupSize];              // where each ray enters its next node: t in the frame
  std::int32_t pop_stride_[kGroupSize];  // kStride if the next node is the last waiting child of its entry, else 0
  PendingHits<Collector> pending_;

  // Since the last sample.
  std::uint64_t cost_ = 0, n_half_rays_ = 0;
  bool any_ended_ = false;
};

}  // namespace fastlines
