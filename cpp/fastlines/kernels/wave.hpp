// Rays that have nothing to do with each other, up to 64 at a time. Each has a stack of its own; all take a step
// together, phase by phase:
//
//   A  each ray's node is tested: children that are leaves go to one list, inner ones to the ray's stack
//   B  each leaf of the list is tested: the pieces that survive go to a second list
//   C  survivors are tested exactly, sixteen at a time, each against its own ray
//   D  each ray takes its nearest node, or is done
//
// Where hits bring nothing nearer any node will do, and phase A has found it already. The first step, that to the root,
// is taken by sixteen rays together when they come (root.hpp).
//
// A ray alone spends most of its time waiting for memory and on mispredicted branches. Here none waits for the step of
// another, what a phase will read is known before it starts, and lists are packed without branches.
//
// Rays come and go by sixteens, as they stand in lanes; which are under way is a set of bits. A stack has an entry for
// each node of which inner children wait: which they are, and where each is entered. Nothing has to be packed or put in
// order for it.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "choice.hpp"
#include "collect.hpp"
#include "cull.hpp"
#include "fetch.hpp"
#include "pairs.hpp"
#include "picks.hpp"
#include "root.hpp"
#include "sixteen.hpp"
#include "survivors.hpp"
#include "tally.hpp"
#include "tested.hpp"

namespace fastlines {

template <class Job>
class Wave {
 public:
  Wave(const WideView& tree, const Job& job) : tree_(tree), root_(tree), collector_(job.collector()) { make_room(8); }

  /// Take in the rays of lanes [first, end) of one sixteen, which it begins. The job takes the answers of those done.
  void add(const RayLanes& rays, int first, int end, Job& job) {
    int sixteen = 0;
    while (n_left_[sixteen] > 0)
      if (++sixteen == kSixteens) {
        step(job);
        sixteen = 0;
      }
    const int to = sixteen * kWidth, n = end - first;
    rays_.template copy<Collector::kAsksWhere>(to, rays, first);
    job.begin(collector_, rays_, to, to + n);
    picks_.take(rays_, to);
    n_left_[sixteen] = n_in_[sixteen] = n;
    cost_ += AloneCost::kRay * std::uint64_t(n);
    n_halves_ += std::uint64_t(n);
    const CullOf<Float16> cull = cull_sixteen(rays, first);
    turn(cull, cull_ + to);
    if (root_.has_inner_only()) {
      pass_root(cull, to, n, job);
    } else {
      std::fill_n(node_ + to, n, 0u);
      std::iota(top_ + to, top_ + to + n, to);
      on_ |= lanes_of(to, n);
    }
  }

  /// What has been done since the last call, or nothing as long as no ray has ended. A ray counts half when it comes
  /// and half when it goes, so that those under way do not make the others look dear.
  Work take_work() {
    if (!std::exchange(any_ended_, false)) return {};
    const Work work{std::exchange(cost_, 0), n_halves_ / 2};
    n_halves_ %= 2;
    return work;
  }

  /// Finish all that are in.
  void drain(Job& job) {
    while (on_) step(job);
  }

 private:
  using Collector = typename Job::Collector;
  static constexpr bool kNearestFirst = Collector::kNearestFirst;
  static constexpr int kSixteens = kLanes / kWidth;
  static constexpr std::uint64_t kHalf = 0xffff'ffff;  // of the lanes

  /// Where the children of a node are entered.
  struct alignas(64) Enters {
    float of[kWidth];
  };
  /// Those that wait, as bits.
  struct Open {
    std::uint32_t first, waiting;
  };
  /// All stacks: the lowest entries of all lanes, which nothing waits in, then the next. Loops have a copy, so that
  /// nothing written can alias it.
  struct Stacks {
    Enters* enters;
    Open* open;
  };
  Stacks stacks() { return {enters_.data(), open_.data()}; }
  static constexpr std::int32_t kLevel = kLanes + 1;  // from an entry to the next; not all in one part of the cache
  /// One entry or none, without a branch, which the compiler would make of a choice.
  static std::int32_t level_if(bool is) { return -std::int32_t(is) & kLevel; }

  /// The lanes for which this holds, which tells it of sixteen at a time.
  template <class Test>
  static std::uint64_t lanes_where(const Test& test) {
    std::uint64_t lanes = 0;
    for (int first = 0; first < kLanes; first += kWidth) lanes |= std::uint64_t(test(first).bits()) << first;
    return lanes;
  }
  template <class Do>
  [[gnu::always_inline]] static void for_each(std::uint64_t lanes, const Do& act) {
    for (; lanes; lanes &= lanes - 1) act(std::uint32_t(std::countr_zero(lanes)));
  }

  static std::uint64_t lanes_of(int first, int n) { return ((std::uint64_t(1) << n) - 1) << first; }

  /// What the n rays in lanes from `first` on, which are a sixteen, would do in a step of their own.
  void pass_root(const CullOf<Float16>& cull, int first, int n, Job& job) {
    cost_ += AloneCost::kRoot * std::uint64_t(n);
    tally(&Steps::nodes, std::uint64_t(n));
    Root::Met met;
    root_.template meet<kNearestFirst>(cull, Float16::load(collector_.limit + first), met);
    const Stacks stacks = this->stacks();
    const std::int32_t above = first + kLevel;
    if constexpr (kNearestFirst)
      turn_columns<kWidth>([&](int child) { return met.enter[child]; }, stacks.enters + above);
    const std::uint32_t first_child = root_.first_child();
    std::uint64_t on = 0;
    for (int i = 0; i < kWidth; ++i) {
      const std::uint32_t children = met.children_of(i);
      const auto next = kNearestFirst ? std::uint32_t(std::int32_t(met.nearest[i]))
                                      : std::uint32_t(std::countr_zero(children | 1u << kWidth));
      const std::uint32_t waiting = children & ~(1u << next);
      node_[first + i] = first_child + next;
      stacks.open[above + i] = {first_child, waiting};
      top_[first + i] = first + i + level_if(waiting != 0);
      on |= std::uint64_t(children != 0) << (first + i);
    }
    on &= lanes_of(first, n);
    on_ |= on;
    for_each(on, [&](std::uint32_t ray) { fetch(tree_.nodes + node_[ray]); });
    for_each(lanes_of(first, n) & ~on, [&](std::uint32_t ray) { end(ray, job); });
  }

  void step(Job& job) {
    if (++deepest_ >= room_) look_for_room();
    test_nodes();
    survivors_.clear();
    survivors_.add(tree_, leaves_, cull_);
    Pairs& survivors = survivors_.lists[0];
    fetch_segments(survivors);
    // Between testing segments and telling what hits, and where rays go to what is nearest also between asking for
    // segments and testing them, there is something else to do: a guess about hits would be known to be wrong only at
    // the end of a long test.
    if constexpr (kNearestFirst) find_nearest(on_ & kHalf);
    test_survivors(survivors);
    if constexpr (kNearestFirst) find_nearest(on_ & ~kHalf);
    tell_hits();
    const auto n_on = std::uint64_t(std::popcount(on_));
    cost_ += AloneCost::kNode * n_on + AloneCost::kLeaf * leaves_.size();
    tally(&Steps::nodes, n_on);
    tally(&Steps::leaves, leaves_.size());
    const std::uint64_t before = on_;
    if constexpr (kNearestFirst)
      take_nearest();
    else
      keep_on();
    for_each(before & ~on_, [&](std::uint32_t ray) { end(ray, job); });
  }

  /// Phase A.
  void test_nodes() {
    const WideNode* const nodes = tree_.nodes;
    const Stacks stacks = this->stacks();
    leaves_.clear();
    Pairs::Tail leaves = leaves_.tail(std::size_t(std::popcount(on_)) * kWidth);
    for_each(on_, [&](std::uint32_t ray) __attribute__((always_inline)) {
      const WideNode& node = nodes[node_[ray]];
      Float16 enter;
      const std::uint32_t lanes = cull_node(cull_[ray], node, collector_.limit[ray], enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      const std::int32_t above = top_[ray] + kLevel;
      std::int32_t top = top_[ray] + level_if(inner != 0);
      stacks.open[above] = {node.first_inner, inner};
      if constexpr (kNearestFirst) {
        enter.store(stacks.enters[above].of);
      } else {
        Open& open = stacks.open[top];
        node_[ray] = open.first + std::uint32_t(std::countr_zero(open.waiting));
        open.waiting &= open.waiting - 1;
        top -= level_if(open.waiting == 0);
        fetch(nodes + node_[ray]);  // any, where nothing waits: the ray ends
      }
      top_[ray] = top;
      leaves.pack(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    });
    leaves_.end(leaves);
  }

  /// List the segments of survivors, and then the first of all sixteen times, for sixteen are read.
  void fetch_segments(const Pairs& survivors) {
    const WideView tree = tree_;
    const std::size_t n = survivors.size();
    if (prims_.size() < n + kWidth) prims_.resize(2 * (n + kWidth));
    std::uint32_t* const to = prims_.data();
    for (std::size_t j = 0; j < n; ++j) {
      to[j] = tree.refs[survivors.what[j]].prim;
      __builtin_prefetch(tree.segments + to[j]);
    }
    std::fill_n(to + n, kWidth, 0u);
  }

  /// Phase C.
  void test_survivors(Pairs& survivors) {
    const std::size_t n = survivors.size();
    cost_ += AloneCost::kTest * n;
    tally(&Steps::pieces, n);
    tally(&Steps::packs, (n + kWidth - 1) / kWidth);
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const what = survivors.what.data(), *const ray = survivors.ray.data();
    for (std::size_t j = 0; j < n; j += kWidth) {
      if (tested_.is_full()) tell_hits();
      test_sixteen(what + j, prims_.data() + j, ray + j, std::min<std::size_t>(n - j, kWidth));
    }
  }

  /// Test n survivors, sixteen at most; `tell_hits` tells what hits.
  [[gnu::always_inline]] void test_sixteen(const std::uint32_t* what, const std::uint32_t* prims,
                                           const std::uint32_t* ray, std::size_t n) {
    Float16 start[3], e[3];
    take_sixteen(tree_, [=](int i) { return prims[i]; }, start, e);
    const auto rays = picks_.template pick<Float16, kLanes>(rays_, 0, ray);
    const Seen<Float16> seen = see<Float16>(rays, start, e);
    Approach<Float16> approach = closest_approach(rays, seen);
    if constexpr (Collector::kAt == At::surface) approach = entry(rays, seen, approach);
    tested_.add(what, ray, rays.margin, approach, approach.hit.bits() & first_lanes(n));
  }

  /// Show the collector what has been hit since the last time.
  void tell_hits() { tested_.tell(tree_, rays_, collector_); }

  /// Phase D: the nearest child of the node on top comes next. A node of which none is within the limit is taken away,
  /// and the one below it is asked, for all such rays together: which they are is never guessed.
  void take_nearest() {
    std::uint64_t asked = std::exchange(on_, 0);
    while (asked) {
      std::uint64_t without = 0;
      for_each(asked, [&](std::uint32_t ray) __attribute__((always_inline)) {
        const bool is_within = enter_[ray] <= collector_.limit[ray];
        top_[ray] -= level_if(!is_within) | emptied_[ray];
        without |= std::uint64_t(!is_within) << ray;
      });
      on_ |= asked & ~without;
      asked = 0;
      for_each(without, [&](std::uint32_t ray) { asked |= std::uint64_t(top_[ray] >= kLevel) << ray; });
      find_nearest(asked);
    }
    for_each(on_, [&](std::uint32_t ray) { fetch(tree_.nodes + node_[ray]); });
  }

  /// Of the nodes on top of these rays' stacks, take the child that is entered first.
  void find_nearest(std::uint64_t asked) {
    const Stacks stacks = this->stacks();
    for_each(asked, [&](std::uint32_t ray) __attribute__((always_inline)) {
      Open& open = stacks.open[top_[ray]];
      const Float16 enter = choose(open.waiting, Float16::load(stacks.enters[top_[ray]].of), kNever);
      const float first = least(enter);
      const auto lane = std::uint32_t(std::countr_zero((enter <= Float16(first)).bits()));
      enter_[ray] = first;
      node_[ray] = open.first + lane;
      open.waiting &= ~(1u << lane);
      emptied_[ray] = level_if(open.waiting == 0);
    });
  }

  /// Phase D where hits bring nothing nearer: those go on that have a node and want more. What stands below the lowest
  /// entry is negative, and no number at all where it is read as a float. Lanes without a ray may hold anything.
  /// Vectors may be read here, though all was written one by one: `top_` long ago, limits seldom.
  void keep_on() {
    on_ &= lanes_where([&](int first) {
      const Float16 top = Float16::load(reinterpret_cast<const float*>(top_ + first));
      return (Float16(0.0f) <= top) & (Float16(kOut) < Float16::load(collector_.limit + first));
    });
  }

  void end(std::uint32_t ray, Job& job) {
    ++n_halves_;
    any_ended_ = true;
    const int sixteen = int(ray) / kWidth;
    if (--n_left_[sixteen] == 0) job.take(rays_, collector_, sixteen * kWidth, sixteen * kWidth + n_in_[sixteen]);
  }

  void look_for_room() {
    deepest_ = kFirst;
    for_each(on_, [&](std::uint32_t ray) { deepest_ = std::max(deepest_, top_[ray] / kLevel + 1); });
    if (2 * deepest_ >= room_) make_room(2 * room_);  // so that it is long before we look again
  }

  /// Let each stack have so many entries.
  void make_room(std::int32_t room) {
    if constexpr (kNearestFirst) enters_.resize(std::size_t(kLevel * room));
    open_.resize(std::size_t(kLevel * room));
    room_ = room;
  }

  static constexpr float kNever = std::numeric_limits<float>::infinity();

  const WideView& tree_;
  Root root_;
  RayLanes rays_;
  Collector collector_;
  CullRay cull_[kLanes];
  Picks picks_;
  std::uint64_t on_ = 0;                               // the rays that are under way
  std::uint32_t node_[kLanes];                         // the node that comes next
  alignas(64) std::int32_t top_[kLanes] = {};          // the uppermost entry of the stack
  int n_in_[kSixteens] = {}, n_left_[kSixteens] = {};  // the rays of each sixteen, and those of them under way

  // The stacks.
  static constexpr std::int32_t kFirst = 1;   // the root's entry, which rays may come in with
  std::int32_t room_ = 0, deepest_ = kFirst;  // entries each, and a bound on those in use
  std::vector<Enters> enters_;
  std::vector<Open> open_;

  // What phases hand to each other.
  Pairs leaves_;
  Survivors<kLanes> survivors_;
  std::vector<std::uint32_t> prims_;  // of survivors

  float enter_[kLanes];           // where the node that comes next is
  std::int32_t emptied_[kLanes];  // whether it was the last of its entry: an entry, or none
  Tested<Collector> tested_;
  // Since they were asked for.
  std::uint64_t cost_ = 0, n_halves_ = 0;
  bool any_ended_ = false;
};

}  // namespace fastlines
