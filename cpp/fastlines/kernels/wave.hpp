// Rays that have nothing to do with each other, sixteen or thirty-two at a time. Each is a slot with a stack of its
// own; all take a step together, phase by phase:
//
//   A  each slot's node is tested: children that are leaves go to one list, inner ones to the slot's stack
//   B  each leaf of the list is tested: the pieces that survive go to a second list
//   C  each survivor is tested exactly, sixteen at a time where the instruction set can pick their rays
//   D  each slot takes its nearest node, or any where hits bring nothing nearer, or is done
//
// A ray alone spends most of its time waiting for memory and on mispredicted branches. Here no slot waits for another,
// what a phase will read is known before it starts, and lists are packed without branches.
#pragma once

#include <optional>

#include "../query/search.hpp"
#include "choice.hpp"
#include "cull.hpp"
#include "fetch.hpp"
#include "lanes.hpp"
#include "pairs.hpp"
#include "sixteen.hpp"
#include "tally.hpp"

namespace fastlines {

template <class Sink>
class Wave {
 public:
  explicit Wave(const WideView& tree) : tree_(tree), slots_(kSlots) {
    for (int i = 0; i < kSlots; ++i) which_[i] = std::uint32_t(i);
  }

  /// Take a ray in; done(tag, sink) is called for rays that are finished.
  template <class Done>
  void add(const Ray& ray, const Sink& sink, std::uint32_t tag, Done&& done) {
    while (n_ == kSlots) step(done);
    const std::uint32_t which = which_[n_++];
    if constexpr (Float16::kLooksUp > 0) put_test(rays_, int(which), ray);
    Slot& slot = slots_[which];
    slot.ray = ray;
    slot.cull = CullRay(ray);
    slot.sink.emplace(sink);
    slot.tag = tag;
    slot.size = 0;
    slot.node = 0;
  }

  /// What the rays that have ended since the last call have cost.
  Work take_work() { return std::exchange(work_, {}); }

  /// Finish all that are in.
  template <class Done>
  void drain(Done&& done) {
    while (n_ > 0) step(done);
  }

 private:
  static constexpr int kSlots = std::max(kWidth, Float16::kLooksUp);
  static constexpr std::size_t kAtOnce = 128;
  static constexpr float kNever = std::numeric_limits<float>::infinity();

  struct Slot {
    CullRay cull;
    Ray ray;
    std::optional<Sink> sink;
    std::uint32_t tag, node;
    // The stack, in no order, above sixteen entries that are never reached.
    std::size_t size = 0;
    std::vector<float> enter = std::vector<float>(8 * kWidth, kNever);
    std::vector<std::uint32_t> child = std::vector<std::uint32_t>(8 * kWidth);

    /// Put the children in these lanes, numbered from `base`, onto the stack.
    void push(std::uint32_t lanes, const Float16& near, std::uint32_t base) {
      if (enter.size() < size + 2 * kWidth) {
        enter.resize(2 * enter.size());
        child.resize(2 * child.size());
      }
      if constexpr (Sink::kNearestFirst) fastlines::pack(lanes, near, enter.data() + kWidth + size);
      pack_numbers(lanes, base, child.data() + kWidth + size);
      size += std::size_t(std::popcount(lanes));
    }

    /// Take the nearest of the topmost sixteen, or where that does not matter the topmost; false if none is left.
    bool next() {
      if constexpr (!Sink::kNearestFirst) {
        if (size == 0) return false;
        node = child[--size + kWidth];
        return true;
      }
      while (size > 0) {
        const Float16 top = Float16::load(enter.data() + size);  // entries size − 16 … size − 1
        const float nearest = least(top);
        if (nearest <= sink->limit) {
          const std::size_t at = size + std::size_t(std::countr_zero((top <= Float16(nearest)).bits()));
          node = child[at];
          --size;
          enter[at] = enter[size + kWidth];
          child[at] = child[size + kWidth];
          return true;
        }
        size = size > kWidth ? size - kWidth : 0;
      }
      return false;
    }
  };

  template <class Done>
  void step(Done&& done) {
    Slot* const slots = slots_.data();
    const WideView tree = tree_;  // a copy, so that nothing written can alias it

    // A: nodes.
    leaves_.clear();
    Pairs::Tail leaves = leaves_.tail(std::size_t(n_) * kWidth);
    for (int i = 0, n = n_; i < n; ++i) {
      const std::uint32_t which = which_[i];
      Slot& slot = slots[which];
      const WideNode& node = tree.nodes[slot.node];
      Float16 near;
      const std::uint32_t lanes = cull_node(slot.cull, node, slot.sink->limit, near);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      slot.push(inner, near, node.first_inner);
      leaves.pack(lanes ^ inner, node.first_leaf - node.n_inner, which);
    }
    leaves_.end(leaves);

    // B: leaves.
    const std::size_t n_leaves = leaves_.size();
    const std::uint32_t *const leaf = leaves_.what.data(), *const of = leaves_.ray.data();
    survivors_.clear();
    Pairs::Tail survivors = survivors_.tail(n_leaves * kWidth);
    for (std::size_t j = 0; j < n_leaves; ++j) fetch(tree.leaves + leaf[j]);
    for (std::size_t j = 0; j < n_leaves; ++j) places_[j] = place_of(tree.leaves[leaf[j]], slots[of[j]].cull.across);
    for (std::size_t j = 0; j < n_leaves; ++j)
      near_[j] = cull_leaf(slots[of[j]].cull.across, tree.leaves[leaf[j]], places_[j]);
    for (std::size_t i = 0, n = pack_set(near_, n_leaves, met_); i < n; ++i) {
      const std::uint32_t j = met_[i];
      survivors.pack(near_[j], tree.leaves[leaf[j]].first_ref, of[j]);
    }
    survivors_.end(survivors);

    // C: survivors.
    const std::size_t n = survivors_.size();
    survivors_.pad();
    for (std::size_t j = 0; j < n; ++j) __builtin_prefetch(tree.refs + survivors_.what[j]);
    for (std::size_t j = 0; j < n; ++j) __builtin_prefetch(tree.segments + tree.refs[survivors_.what[j]].prim);
    if constexpr (Float16::kLooksUp > 0)
      for (std::size_t j = 0; j < n; j += kAtOnce) test_many<Float16>(j, std::min(n - j, kAtOnce));
    else
      for (std::size_t j = 0; j < n; ++j) test_one(slots[survivors_.ray[j]], tree.refs[survivors_.what[j]]);
    work_.cost += AloneCost::kNode * std::uint64_t(n_) + AloneCost::kLeaf * n_leaves + AloneCost::kTest * n;
    tally(&Steps::nodes, std::uint64_t(n_));
    tally(&Steps::leaves, n_leaves);
    tally(&Steps::pieces, n);
    tally(&Steps::packs, (n + kWidth - 1) / kWidth);

    // D: what comes next.
    for (int i = n_; i-- > 0;) {
      Slot& slot = slot_of(i);
      if (!slot.sink->done() && slot.next()) {
        fetch(tree_.nodes + slot.node);
        continue;
      }
      work_ += {AloneCost::kRay, 1};
      done(slot.tag, *slot.sink);
      std::swap(which_[i], which_[--n_]);
    }
  }

  void test_one(Slot& slot, const Reference& ref) {
    if (!slot.sink->done()) test_segment(slot.ray, tree_.segments[ref.prim], tree_.frame, ref, *slot.sink);
  }

  /// Test survivors [first, first + n) exactly, at most kAtOnce. What hits is dealt with when all have been tested:
  /// a guess about hits would be known to be wrong only at the end of a long test. F is Float16, as of ChosenRays.
  template <class F>
  void test_many(std::size_t first, std::size_t n) {
    const std::uint32_t* const what = survivors_.what.data() + first;
    const std::uint32_t* const slot = survivors_.ray.data() + first;
    alignas(64) float s[kAtOnce], t[kAtOnce], dist2[kAtOnce];
    std::uint32_t hits[kAtOnce + kWidth];
    std::size_t n_hits = 0;
    for (std::size_t j = 0; j < n; j += kWidth) {
      F start[3], e[3];
      take_sixteen(tree_, [&](int i) { return tree_.refs[what[j + std::size_t(i)]].prim; }, start, e);
      const ChosenRays<F, kSlots> rays(rays_, 0, slot + j);
      const Approach<F> approach = closest_approach(rays, see<F>(rays, start, e));
      approach.s.store(s + j);
      approach.t.store(t + j);
      approach.dist2.store(dist2 + j);
      const std::uint32_t hit = approach.hit.bits() & first_lanes(n - j);
      pack_numbers(hit, std::uint32_t(j), hits + n_hits);
      n_hits += std::size_t(std::popcount(hit));
    }
    for (std::size_t i = 0; i < n_hits; ++i) {
      const std::uint32_t j = hits[i];
      Slot& of = slots_[slot[j]];
      const Reference& ref = tree_.refs[what[j]];
      of.sink->add({of.ray, tree_.segments[ref.prim], tree_.frame, {s[j], t[j], dist2[j], true}, ref});
    }
  }

  Slot& slot_of(int i) { return slots_[which_[i]]; }

  const WideView& tree_;
  int n_ = 0;
  std::vector<Slot> slots_;
  TestLanes<kSlots> rays_;               // those of the slots
  std::uint32_t which_[kSlots];          // the slots in use, then those that are free
  Pairs leaves_, survivors_;             // each for a slot
  LeafPlace places_[kSlots * kWidth];    // of the leaves
  std::uint32_t near_[kSlots * kWidth];  // the pieces of each leaf that survive
  std::uint32_t met_[kSlots * kWidth];   // the leaves of which any does
  Work work_;
};

}  // namespace fastlines
