// Rays that have nothing to do with each other, up to 64 at a time. Each has a stack of its own; all take a step
// together, phase by phase:
//
//   A  each ray's node is tested: children that are leaves go to one list, inner ones to the ray's stack
//   B  each leaf of the list is tested: the pieces that survive go to a second list
//   C  survivors are tested exactly, sixteen at a time, each against its own ray
//   D  each ray takes its nearest node, or any where hits bring nothing nearer, or is done
//
// A ray alone spends most of its time waiting for memory and on mispredicted branches. Here none waits for the step of
// another, what a phase will read is known before it starts, and lists are packed without branches.
//
// Rays come and go by sixteens, as they stand in lanes. A stack has an entry for each node of which inner children
// wait: which they are, and where each is entered. Nothing has to be packed or put in order for it.
#pragma once

#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "choice.hpp"
#include "collect.hpp"
#include "cull.hpp"
#include "fetch.hpp"
#include "pairs.hpp"
#include "picks.hpp"
#include "sixteen.hpp"
#include "survivors.hpp"
#include "tally.hpp"

namespace fastlines {

template <class Job>
class Wave {
 public:
  Wave(const WideView& tree, const Job& job) : tree_(tree), collector_(job.collector(tree)) { make_room(3); }

  /// Take in the rays of lanes [first, end) of one sixteen, which it begins. The job takes the answers of those done.
  void add(const RayLanes& rays, int first, int end, Job& job) {
    int sixteen = 0;
    while (n_left_[sixteen] > 0)
      if (++sixteen == kSixteens) {
        step(job);
        sixteen = 0;
      }
    const int to = sixteen * kWidth, n = end - first;
    rays_.copy(to, rays, first);
    job.begin(collector_, rays_, to, to + n);
    cull_rays(rays_, to, cull_ + to);
    picks_.take(rays_, to);
    for (int i = to; i < to + n; ++i) {
      node_[i] = depth_[i] = 0;
      on_[n_on_++] = std::uint32_t(i);
    }
    n_left_[sixteen] = n_in_[sixteen] = n;
    cost_ += AloneCost::kRay * std::uint64_t(n);
    n_halves_ += std::uint64_t(n);
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
    while (n_on_ > 0) step(job);
  }

 private:
  using Collector = typename Job::Collector;
  static constexpr bool kNearestFirst = Collector::kNearestFirst;
  static constexpr int kSixteens = kLanes / kWidth;
  static constexpr int kTogether = Picks::kOf;  // rays whose survivors are tested together
  static constexpr std::size_t kAtOnce = 128;

  /// Where the children of a node are entered.
  struct alignas(64) Enters {
    float of[kWidth];
  };
  /// Those that wait, as bits.
  struct Open {
    std::uint32_t first, waiting;
  };
  /// What has been tested, and which of it hits.
  struct Tested {
    alignas(64) float s[kAtOnce], t[kAtOnce], dist2[kAtOnce];
    std::uint32_t what[kAtOnce], lane[kAtOnce], hits[kAtOnce + kWidth];
    std::size_t n = 0, n_hits = 0;
  };
  /// All stacks. Loops have a copy, so that nothing written can alias it.
  struct Stacks {
    Enters* enters;
    Open* open;
    std::uint32_t room;
    /// Where an entry is, the lowest of which is number 1.
    std::size_t place(std::uint32_t ray, std::uint32_t depth) const { return ray * room + depth; }
  };
  Stacks stacks() { return {enters_.data(), open_.data(), room_}; }

  void step(Job& job) {
    if (++deepest_ + 1 >= room_) look_for_room();
    test_nodes();
    survivors_.clear();
    survivors_.add(tree_, leaves_, cull_);
    for (const Pairs& survivors : survivors_.lists) fetch_segments(survivors);
    // Between testing segments and telling what hits, and where rays go to what is nearest also between asking for
    // segments and testing them, there is something else to do: a guess about hits would be known to be wrong only at
    // the end of a long test.
    if constexpr (kNearestFirst) find_nearest(on_, 0, n_on_ / 2);
    for (int i = 0; i < survivors_.kLists; ++i) test_survivors(survivors_.lists[i], i * kTogether);
    if constexpr (kNearestFirst)
      find_nearest(on_, n_on_ / 2, n_on_);
    else
      take_any();
    tell_hits();
    cost_ += AloneCost::kNode * std::uint64_t(n_on_) + AloneCost::kLeaf * leaves_.size();
    tally(&Steps::nodes, std::uint64_t(n_on_));
    tally(&Steps::leaves, leaves_.size());
    const int n_before = n_on_;
    if constexpr (kNearestFirst)
      take_nearest();
    else
      keep_on();
    for (int i = 0; i < n_on_; ++i) fetch(tree_.nodes + node_[on_[i]]);
    for (int i = 0; i < n_before - n_on_; ++i) end(ended_[i], job);
  }

  /// Phase A.
  void test_nodes() {
    const WideNode* const nodes = tree_.nodes;
    const Stacks stacks = this->stacks();
    leaves_.clear();
    Pairs::Tail leaves = leaves_.tail(std::size_t(n_on_) * kWidth);
    for (int i = 0, n = n_on_; i < n; ++i) {
      const std::uint32_t ray = on_[i];
      const WideNode& node = nodes[node_[ray]];
      Float16 enter;
      const std::uint32_t lanes = cull_node(cull_[ray], node, collector_.limit[ray], enter);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      const std::size_t top = stacks.place(ray, depth_[ray] + 1);
      if constexpr (kNearestFirst) enter.store(stacks.enters[top].of);
      stacks.open[top] = {node.first_inner, inner};
      depth_[ray] += inner != 0;
      leaves.pack(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    }
    leaves_.end(leaves);
  }

  void fetch_segments(const Pairs& survivors) {
    const WideView tree = tree_;
    for (std::size_t j = 0; j < survivors.size(); ++j)
      __builtin_prefetch(tree.segments + tree.refs[survivors.what[j]].prim);
  }

  /// Phase C, for the rays in lanes from `first` on.
  void test_survivors(Pairs& survivors, int first) {
    const std::size_t n = survivors.size();
    cost_ += AloneCost::kTest * n;
    tally(&Steps::pieces, n);
    tally(&Steps::packs, (n + kWidth - 1) / kWidth);
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const what = survivors.what.data(), *const ray = survivors.ray.data();
    for (std::size_t j = 0; j < n; j += kWidth) {
      if (tested_.n == kAtOnce) tell_hits();
      test_sixteen(what + j, ray + j, std::min<std::size_t>(n - j, kWidth), first);
    }
  }

  /// Test n survivors, sixteen at most; `tell_hits` tells what hits.
  [[gnu::always_inline]] void test_sixteen(const std::uint32_t* what, const std::uint32_t* ray, std::size_t n,
                                           int first) {
    Float16 start[3], e[3];
    take_sixteen(tree_, [&](int i) { return tree_.refs[what[i]].prim; }, start, e);
    const auto rays = picks_.template pick<Float16, kTogether>(rays_, first, ray);
    const Approach<Float16> approach = closest_approach(rays, see<Float16>(rays, start, e));
    const std::size_t at = tested_.n;
    if constexpr (Collector::kAsksWhere) {
      approach.s.store(tested_.s + at);
      approach.t.store(tested_.t + at);
      approach.dist2.store(tested_.dist2 + at);
      std::memcpy(tested_.what + at, what, kWidth * sizeof *what);
    }
    for (int i = 0; i < kWidth; ++i) tested_.lane[at + std::size_t(i)] = std::uint32_t(first) + ray[i];
    const std::uint32_t hit = approach.hit.bits() & first_lanes(n);
    pack_numbers(hit, std::uint32_t(at), tested_.hits + tested_.n_hits);
    tested_.n_hits += std::size_t(std::popcount(hit));
    tested_.n = at + kWidth;
  }

  /// Show the collector what has been hit since the last time.
  void tell_hits() {
    for (std::size_t i = 0; i < tested_.n_hits; ++i) {
      const std::uint32_t j = tested_.hits[i];
      const int lane = int(tested_.lane[j]);
      if constexpr (Collector::kAsksWhere)
        collector_.take_one(rays_, lane, {tested_.s[j], tested_.t[j], tested_.dist2[j], true},
                            tree_.refs[tested_.what[j]]);
      else
        collector_.take_one(rays_, lane, {}, {});
    }
    tested_.n = tested_.n_hits = 0;
  }

  /// Phase D where the nearest child of the node on top comes next. A node of which none is within the limit is taken
  /// away, and the one below it is asked, for all such rays together: which they are is never guessed.
  void take_nearest() {
    const Stacks stacks = this->stacks();
    const std::uint32_t* asked = on_;
    int n = n_on_, n_on = 0, n_ended = 0;
    while (n > 0) {
      int n_without = 0;
      for (int i = 0; i < n; ++i) {
        const std::uint32_t ray = asked[i], within = enter_[i] <= collector_.limit[ray];
        Open& open = stacks.open[stacks.place(ray, depth_[ray])];
        node_[ray] = open.first + nearest_[i];
        const std::uint32_t waiting = open.waiting &= ~(1u << nearest_[i]);
        depth_[ray] -= (within ^ 1) | (waiting == 0);
        on_[n_on] = ray;
        n_on += int(within);
        without_[n_without] = ray;
        n_without += int(within ^ 1);
      }
      n = 0;
      for (int i = 0; i < n_without; ++i) {
        const std::uint32_t ray = without_[i], more = std::int32_t(depth_[ray]) > 0;
        asked_[n] = ray;
        n += int(more);
        ended_[n_ended] = ray;
        n_ended += int(more ^ 1);
      }
      asked = asked_;
      find_nearest(asked, 0, n);
    }
    n_on_ = n_on;
  }

  /// Of the nodes on top of some of these rays' stacks, the child that is entered first.
  void find_nearest(const std::uint32_t* asked, int begin, int end) {
    const Stacks stacks = this->stacks();
    for (int i = begin; i < end; ++i) {
      const std::size_t top = stacks.place(asked[i], depth_[asked[i]]);
      const Float16 enter = choose(stacks.open[top].waiting, Float16::load(stacks.enters[top].of), kNever);
      const float first = least(enter);
      enter_[i] = first;
      nearest_[i] = std::uint32_t(std::countr_zero((enter <= Float16(first)).bits()));
    }
  }

  /// Phase D where hits bring nothing nearer: any node comes next. `has_next_` tells which rays have one.
  void take_any() {
    const Stacks stacks = this->stacks();
    for (int i = 0, n = n_on_; i < n; ++i) {
      const std::uint32_t ray = on_[i], depth = depth_[ray];
      Open& open = stacks.open[stacks.place(ray, depth)];
      const std::uint32_t waiting = open.waiting, others = waiting & (waiting - 1);
      node_[ray] = open.first + std::uint32_t(std::countr_zero(waiting));
      open.waiting = others;
      depth_[ray] = depth - (others == 0);
      has_next_[i] = depth > 0;
    }
  }

  /// Of these rays, those go on that want more.
  void keep_on() {
    int n_on = 0, n_ended = 0;
    for (int i = 0, n = n_on_; i < n; ++i) {
      const std::uint32_t ray = on_[i];
      const std::uint32_t goes_on = has_next_[i] & (collector_.limit[ray] != kOut);
      on_[n_on] = ray;
      n_on += int(goes_on);
      ended_[n_ended] = ray;
      n_ended += int(goes_on ^ 1);
    }
    n_on_ = n_on;
  }

  void end(std::uint32_t ray, Job& job) {
    ++n_halves_;
    any_ended_ = true;
    const int sixteen = int(ray) / kWidth;
    if (--n_left_[sixteen] == 0) job.take(rays_, collector_, sixteen * kWidth, sixteen * kWidth + n_in_[sixteen]);
  }

  void look_for_room() {
    deepest_ = 0;
    for (int i = 0; i < n_on_; ++i) deepest_ = std::max(deepest_, depth_[on_[i]] + 1);
    if (deepest_ + 1 >= room_) make_room(2 * room_ + 1);
  }

  /// Let each stack have so many entries: an odd number, so that not all use the same part of the cache.
  void make_room(std::uint32_t room) {
    std::vector<Enters> enters(kLanes * std::size_t(room));
    std::vector<Open> open(kLanes * std::size_t(room));
    for (std::size_t i = 0; i < kLanes; ++i) {
      std::copy_n(enters_.data() + i * room_, room_, enters.data() + i * room);
      std::copy_n(open_.data() + i * room_, room_, open.data() + i * room);
    }
    enters_ = std::move(enters);
    open_ = std::move(open);
    room_ = room;
  }

  static constexpr float kNever = std::numeric_limits<float>::infinity();

  const WideView& tree_;
  RayLanes rays_;
  Collector collector_;
  CullRay cull_[kLanes];
  Picks picks_;
  std::uint32_t node_[kLanes], depth_[kLanes];  // the node that comes next; entries of the stack
  std::uint32_t on_[kLanes];                    // the rays that are under way
  int n_on_ = 0;
  int n_in_[kSixteens] = {}, n_left_[kSixteens] = {};  // the rays of each sixteen, and those of them under way

  // The stacks.
  std::uint32_t room_ = 0, deepest_ = 0;  // entries each, and a bound on those in use
  std::vector<Enters> enters_;
  std::vector<Open> open_;

  // What phases hand to each other.
  Pairs leaves_;
  Survivors<kTogether> survivors_;
  std::uint32_t asked_[kLanes], nearest_[kLanes], without_[kLanes], has_next_[kLanes], ended_[kLanes];
  float enter_[kLanes];
  Tested tested_;
  // Since they were asked for.
  std::uint64_t cost_ = 0, n_halves_ = 0;
  bool any_ended_ = false;
};

}  // namespace fastlines
