// The wavefront: up to 64 incoherent rays, each with a stack of its own. All rays advance by one node per step, in
// phases:
//
//   A  cull the node of each ray: list the leaves that it hits, push the inner children
//   B  cull those leaves: list the pieces that survive
//   C  test the survivors exactly, 16 at a time, each against its own ray
//   D  choose the next node of each ray, or end the ray
//
// A single ray waits for memory and for mispredicted branches most of its time. Here no ray waits for another: each
// phase knows what it will read before it starts, and lists are compressed without branches.
//
// If hits do not shrink limits, any node may come next, and phase A has chosen it already. Packets pass the root when
// they come in (root_cull.hpp).
//
// Rays come and go by packets, and a bit set says which lanes are active. A stack entry is a node with waiting inner
// children: a bit for each, and the distances at which they are entered. So nothing is sorted or compressed for a
// stack.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "../collect/collector.hpp"
#include "../cost/step_cost.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/exact_test.hpp"
#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"
#include "../intersect/root_cull.hpp"
#include "../rays/ray_gather.hpp"
#include "leaf_survivors.hpp"
#include "pending_hits.hpp"
#include "work_list.hpp"

namespace fastlines {

template <RayPrimitive P, class Query>
class Wavefront {
 public:
  Wavefront(const WideBvhView<P>& tree, const Query& query) : tree_(tree), root_(tree), collector_(query.collector()) {
    resize_stacks(8);
  }

  /// Add the rays of lanes [first, end), where `first` begins a packet. Rays that end are stored by the query.
  void add(const RayGroup& rays, int first, int end, Query& query) {
    int packet = 0;
    while (n_left_[packet] > 0)
      if (++packet == kPackets) {
        step(query);
        packet = 0;
      }
    const int to = packet * kSimdWidth, n = end - first;
    rays_.template copy<Collector::kTraits.needs_position>(to, rays, first);
    collector_.begin(rays_, to, to + n);
    gather_.load(rays_, to);
    n_left_[packet] = n_in_[packet] = n;
    cost_ += SingleStepCost::kRay * std::uint64_t(n);
    n_half_rays_ += std::uint64_t(n);
    const CullRayOf<FloatX16> cull = cull_packet(rays, first);
    transpose(cull, cull_ + to);
    if (root_.has_inner_only()) {
      pass_root(cull, to, n, query);
    } else {
      std::fill_n(node_ + to, n, 0u);
      std::iota(top_ + to, top_ + to + n, to);
      active_ |= lane_bits(to, n);
    }
  }

  /// Returns what has been done since the last call; nothing while no ray has ended. A ray counts half when it comes
  /// and half when it ends, so that active rays do not make the others look expensive.
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
  static constexpr int kPackets = kGroupSize / kSimdWidth;
  static constexpr std::uint64_t kHalf = 0xffff'ffff;  // of the lanes

  /// The t at which each child of a node is entered.
  struct alignas(64) EntryDistances {
    float of[kSimdWidth];
  };
  /// A node with waiting children: the index of its first inner child, and a bit for each that waits.
  struct StackEntry {
    std::uint32_t first, waiting;
  };
  /// All stacks, level by level; the lowest level is empty. Loops work on a copy, which no write can alias.
  struct Stacks {
    EntryDistances* enters;
    StackEntry* open;
  };
  Stacks stacks() { return {enters_.data(), open_.data()}; }
  /// From an entry of a stack to the next one. It is odd, so that a stack does not stay in one cache set.
  static constexpr std::int32_t kEntryStride = kGroupSize + 1;
  /// One entry or none. Written with bits, because the compiler would make a branch of a choice.
  static std::int32_t stride_if(bool is) { return -std::int32_t(is) & kEntryStride; }

  /// The lanes for which a test of a packet holds.
  template <class Test>
  static std::uint64_t lanes_where(const Test& test) {
    std::uint64_t lanes = 0;
    for (int first = 0; first < kGroupSize; first += kSimdWidth) lanes |= std::uint64_t(test(first).bits()) << first;
    return lanes;
  }
  template <class Do>
  [[gnu::always_inline]] static void for_each(std::uint64_t lanes, const Do& act) {
    for (; lanes; lanes &= lanes - 1) act(std::uint32_t(std::countr_zero(lanes)));
  }

  static std::uint64_t lane_bits(int first, int n) { return ((std::uint64_t(1) << n) - 1) << first; }

  /// Take the packet of n rays from lane `first` past the root: the first step of each.
  void pass_root(const CullRayOf<FloatX16>& cull, int first, int n, Query& query) {
    cost_ += SingleStepCost::kRoot * std::uint64_t(n);
    count_step(&StepCounters::nodes, std::uint64_t(n));
    RootCull::Hits root_hits;
    root_.template cull<kShrinksLimit>(cull, FloatX16::load(collector_.limit + first), root_hits);
    const Stacks stacks = this->stacks();
    const std::int32_t above = first + kEntryStride;
    if constexpr (kShrinksLimit)
      transpose_columns<kSimdWidth>([&](int child) { return root_hits.enter[child]; }, stacks.enters + above);
    const std::uint32_t first_child = root_.first_child();
    std::uint64_t entered = 0;
    for (int i = 0; i < kSimdWidth; ++i) {
      const std::uint32_t children = root_hits.children_of(i);
      const auto next = kShrinksLimit ? std::uint32_t(std::int32_t(root_hits.nearest[i]))
                                      : std::uint32_t(std::countr_zero(children | 1u << kSimdWidth));
      const std::uint32_t waiting = children & ~(1u << next);
      node_[first + i] = first_child + next;
      stacks.open[above + i] = {first_child, waiting};
      top_[first + i] = first + i + stride_if(waiting != 0);
      entered |= std::uint64_t(children != 0) << (first + i);
    }
    entered &= lane_bits(first, n);
    active_ |= entered;
    for_each(entered, [&](std::uint32_t ray) { prefetch(tree_.nodes + node_[ray]); });
    for_each(lane_bits(first, n) & ~entered, [&](std::uint32_t ray) { end(ray, query); });
  }

  void step(Query& query) {
    if (++deepest_ >= room_) reserve_stacks();
    test_nodes();
    survivors_.clear();
    survivors_.add(tree_, leaves_, cull_);
    WorkList& survivors = survivors_.lists[0];
    prefetch_prims(survivors);
    // Find the next nodes between the prefetch and the tests, and between the tests and the report of hits. A branch on
    // hits would be resolved only at the end of a long test, so other work comes first.
    if constexpr (kShrinksLimit) find_nearest(active_ & kHalf);
    test_survivors(survivors);
    if constexpr (kShrinksLimit) find_nearest(active_ & ~kHalf);
    flush_hits();
    const auto n_active = std::uint64_t(std::popcount(active_));
    cost_ += SingleStepCost::kNode * n_active + SingleStepCost::kLeaf * leaves_.size();
    count_step(&StepCounters::nodes, n_active);
    count_step(&StepCounters::leaves, leaves_.size());
    const std::uint64_t before = active_;
    if constexpr (kShrinksLimit)
      take_nearest();
    else
      drop_finished();
    for_each(before & ~active_, [&](std::uint32_t ray) { end(ray, query); });
  }

  /// Phase A: cull the node of each ray.
  void test_nodes() {
    const WideNode* const nodes = tree_.nodes;
    const Stacks stacks = this->stacks();
    leaves_.clear();
    WorkList::Appender leaves = leaves_.appender(std::size_t(std::popcount(active_)) * kSimdWidth);
    for_each(active_, [&](std::uint32_t ray) __attribute__((always_inline)) {
      const WideNode& node = nodes[node_[ray]];
      FloatX16 enter;
      const std::uint32_t lanes = cull_node(cull_[ray], node, collector_.limit[ray], enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      const std::int32_t above = top_[ray] + kEntryStride;
      std::int32_t top = top_[ray] + stride_if(inner != 0);
      stacks.open[above] = {node.first_inner, inner};
      if constexpr (kShrinksLimit) {
        enter.store(stacks.enters[above].of);
      } else {
        StackEntry& open = stacks.open[top];
        node_[ray] = open.first + std::uint32_t(std::countr_zero(open.waiting));
        open.waiting &= open.waiting - 1;
        top -= stride_if(open.waiting == 0);
        prefetch(nodes + node_[ray]);  // an arbitrary node if nothing waits: the ray ends
      }
      top_[ray] = top;
      leaves.compress(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    });
    leaves_.end(leaves);
  }

  /// List and prefetch the primitives of the survivors, padded by primitive 0 to whole packets.
  void prefetch_prims(const WorkList& survivors) {
    const WideBvhView<P> tree = tree_;
    const std::size_t n = survivors.size();
    if (prims_.size() < n + kSimdWidth) prims_.resize(2 * (n + kSimdWidth));
    std::uint32_t* const to = prims_.data();
    for (std::size_t j = 0; j < n; ++j) {
      to[j] = tree.refs[survivors.what[j]].prim;
      __builtin_prefetch(tree.items + to[j]);
    }
    std::fill_n(to + n, kSimdWidth, 0u);
  }

  /// Phase C: test the survivors exactly.
  void test_survivors(WorkList& survivors) {
    const std::size_t n = survivors.size();
    cost_ += SingleStepCost::kTest * n;
    count_step(&StepCounters::pieces, n);
    count_step(&StepCounters::packs, (n + kSimdWidth - 1) / kSimdWidth);
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const what = survivors.what.data(), *const ray = survivors.ray.data();
    for (std::size_t j = 0; j < n; j += kSimdWidth) {
      if (pending_.is_full()) flush_hits();
      test_packet(what + j, prims_.data() + j, ray + j, std::min<std::size_t>(n - j, kSimdWidth));
    }
  }

  /// Test n survivors, at most a packet. `flush_hits` reports the hits.
  [[gnu::always_inline]] void test_packet(const std::uint32_t* what, const std::uint32_t* prims,
                                          const std::uint32_t* ray, std::size_t n) {
    const auto lanes = load_lanes(tree_, [=](int i) { return prims[i]; });
    const auto rays = gather_.template gather<FloatX16, kGroupSize>(rays_, 0, ray);
    const auto test = P::template test<FloatX16>(rays, lanes);
    const auto& approach = approach_at<Collector::kAt>(test);
    pending_.add(what, ray, rays.tie_tolerance, approach, approach.hit.bits() & lane_mask(n));
  }

  /// Report the pending hits to the collector.
  void flush_hits() { pending_.flush(tree_.refs, rays_, collector_); }

  /// Phase D: the nearest child of the topmost entry comes next. If no child is within the limit, pop the entry and
  /// look at the one below. All such rays do so together, so that no branch depends on a single ray.
  void take_nearest() {
    std::uint64_t searching = std::exchange(active_, 0);
    while (searching) {
      std::uint64_t without = 0;
      for_each(searching, [&](std::uint32_t ray) __attribute__((always_inline)) {
        const bool is_within = enter_[ray] <= collector_.limit[ray];
        top_[ray] -= stride_if(!is_within) | emptied_[ray];
        without |= std::uint64_t(!is_within) << ray;
      });
      active_ |= searching & ~without;
      searching = 0;
      for_each(without, [&](std::uint32_t ray) { searching |= std::uint64_t(top_[ray] >= kEntryStride) << ray; });
      find_nearest(searching);
    }
    for_each(active_, [&](std::uint32_t ray) { prefetch(tree_.nodes + node_[ray]); });
  }

  /// Take the child that is entered first from the topmost entry of each of these rays.
  void find_nearest(std::uint64_t rays) {
    const Stacks stacks = this->stacks();
    for_each(rays, [&](std::uint32_t ray) __attribute__((always_inline)) {
      StackEntry& open = stacks.open[top_[ray]];
      const FloatX16 enter = blend(open.waiting, FloatX16::load(stacks.enters[top_[ray]].of), kNever);
      const float first = reduce_min(enter);
      const auto lane = std::uint32_t(std::countr_zero((enter <= FloatX16(first)).bits()));
      enter_[ray] = first;
      node_[ray] = open.first + lane;
      open.waiting &= ~(1u << lane);
      emptied_[ray] = stride_if(open.waiting == 0);
    });
  }

  /// Phase D if hits do not shrink limits: end the rays that have no node or want no more hits. An index below the
  /// lowest entry is negative, and NaN if it is read as a float. Lanes without a ray may hold anything. Packets can be
  /// loaded here, although lanes are stored one by one: `top_` was stored long ago, and limits change seldom.
  void drop_finished() {
    active_ &= lanes_where([&](int first) {
      const FloatX16 top = FloatX16::load(reinterpret_cast<const float*>(top_ + first));
      return (FloatX16(0.0f) <= top) & (FloatX16(kNoMoreHits) < FloatX16::load(collector_.limit + first));
    });
  }

  void end(std::uint32_t ray, Query& query) {
    ++n_half_rays_;
    any_ended_ = true;
    const int packet = int(ray) / kSimdWidth;
    if (--n_left_[packet] == 0)
      query.store(rays_, collector_, packet * kSimdWidth, packet * kSimdWidth + n_in_[packet]);
  }

  void reserve_stacks() {
    deepest_ = kFirst;
    for_each(active_, [&](std::uint32_t ray) { deepest_ = std::max(deepest_, top_[ray] / kEntryStride + 1); });
    if (2 * deepest_ >= room_) resize_stacks(2 * room_);  // so that this is rare
  }

  /// Make room for this many entries per stack.
  void resize_stacks(std::int32_t room) {
    if constexpr (kShrinksLimit) enters_.resize(std::size_t(kEntryStride * room));
    open_.resize(std::size_t(kEntryStride * room));
    room_ = room;
  }

  static constexpr float kNever = std::numeric_limits<float>::infinity();

  const WideBvhView<P>& tree_;
  RootCull root_;
  RayGroup rays_;
  Collector collector_;
  CullRay cull_[kGroupSize];
  RayGather gather_;
  std::uint64_t active_ = 0;                         // a bit for each active lane
  std::uint32_t node_[kGroupSize];                   // the next node of each ray
  alignas(64) std::int32_t top_[kGroupSize] = {};    // the topmost entry of each stack
  int n_in_[kPackets] = {}, n_left_[kPackets] = {};  // the rays of each packet, and how many are active

  // The stacks.
  static constexpr std::int32_t kFirst = 1;   // the entry of the root, with which rays may come in
  std::int32_t room_ = 0, deepest_ = kFirst;  // entries per stack, and a bound on those in use
  std::vector<EntryDistances> enters_;
  std::vector<StackEntry> open_;

  // What one phase hands to the next.
  WorkList leaves_;
  LeafSurvivors<kGroupSize> survivors_;
  std::vector<std::uint32_t> prims_;  // of survivors

  float enter_[kGroupSize];           // where each ray enters its next node
  std::int32_t emptied_[kGroupSize];  // one entry if that node was the last of its entry, else none
  PendingHits<Collector> pending_;
  // Since the last sample.
  std::uint64_t cost_ = 0, n_half_rays_ = 0;
  bool any_ended_ = false;
};

}  // namespace fastlines
