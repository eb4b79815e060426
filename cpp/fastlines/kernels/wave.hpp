// Sixteen rays at a time that have nothing to do with each other. Each is a slot with a stack of its own; all take a
// step together, phase by phase:
//
//   A  each slot's node is tested: children that are leaves go to one list, inner ones to the slot's stack
//   B  each leaf of the list is tested: the pieces that survive go to a second list
//   C  each survivor is tested exactly
//   D  each slot takes its nearest node, or is done
//
// A ray alone spends most of its time waiting for memory and on mispredicted branches. Here no slot waits for another,
// what a phase will read is known before it starts, and lists are packed without branches.
#pragma once

#include <optional>

#include "../query/search.hpp"
#include "cull.hpp"
#include "fetch.hpp"
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
    Slot& slot = slot_of(n_++);
    slot.ray = ray;
    slot.cull = CullRay(ray);
    slot.sink.emplace(sink);
    slot.tag = tag;
    slot.size = 0;
    slot.node = 0;
  }

  /// Finish all that are in.
  template <class Done>
  void drain(Done&& done) {
    while (n_ > 0) step(done);
  }

 private:
  static constexpr int kSlots = 16;
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

    /// Room for sixteen more.
    void reserve() {
      if (enter.size() >= size + 2 * kWidth) return;
      enter.resize(2 * enter.size());
      child.resize(2 * child.size());
    }

    /// Take the nearest of the topmost sixteen; false if none is left.
    bool next() {
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
    // A: nodes.
    leaf_.resize(std::size_t(n_ + 1) * kWidth);
    of_leaf_.resize(leaf_.size());
    std::size_t n_leaves = 0;
    for (int i = 0; i < n_; ++i) {
      Slot& slot = slot_of(i);
      const WideNode& node = tree_.nodes[slot.node];
      Float16 near;
      const std::uint32_t lanes = cull_node(slot.cull, node, slot.sink->limit, near);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1), leaves = lanes ^ inner;
      slot.reserve();
      pack(inner, near, slot.enter.data() + kWidth + slot.size);
      pack_numbers(inner, node.first_inner, slot.child.data() + kWidth + slot.size);
      slot.size += std::size_t(std::popcount(inner));
      pack_numbers(leaves, node.first_leaf - node.n_inner, leaf_.data() + n_leaves);
      for (int k = 0; k < kWidth; ++k) of_leaf_[n_leaves + std::size_t(k)] = which_[i];
      n_leaves += std::size_t(std::popcount(leaves));
    }

    // B: leaves.
    ref_.resize((n_leaves + 1) * kWidth);
    of_ref_.resize(ref_.size());
    place_.resize(n_leaves);
    std::size_t n_refs = 0;
    for (std::size_t j = 0; j < n_leaves; ++j) fetch(tree_.leaves + leaf_[j]);
    for (std::size_t j = 0; j < n_leaves; ++j) place_[j] = LeafPlace(slots_[of_leaf_[j]].cull, tree_.leaves[leaf_[j]]);
    for (std::size_t j = 0; j < n_leaves; ++j) {
      const WideLeaf& leaf = tree_.leaves[leaf_[j]];
      const std::uint32_t lanes = cull_leaf(slots_[of_leaf_[j]].cull, leaf, place_[j]);
      pack_numbers(lanes, leaf.first_ref, ref_.data() + n_refs);
      for (int k = 0; k < kWidth; ++k) of_ref_[n_refs + std::size_t(k)] = of_leaf_[j];
      n_refs += std::size_t(std::popcount(lanes));
    }

    tally(&Steps::nodes, std::uint64_t(n_));
    tally(&Steps::leaves, n_leaves);
    tally(&Steps::pieces, n_refs);

    // C: survivors.
    for (std::size_t j = 0; j < n_refs; ++j) __builtin_prefetch(tree_.refs + ref_[j]);
    for (std::size_t j = 0; j < n_refs; ++j) __builtin_prefetch(tree_.segments + tree_.refs[ref_[j]].prim);
    for (std::size_t j = 0; j < n_refs; ++j) {
      Slot& slot = slots_[of_ref_[j]];
      const Reference& ref = tree_.refs[ref_[j]];
      if (!slot.sink->done()) test_segment(slot.ray, tree_.segments[ref.prim], tree_.frame, ref, *slot.sink);
    }

    // D: what comes next.
    for (int i = n_; i-- > 0;) {
      Slot& slot = slot_of(i);
      if (!slot.sink->done() && slot.next()) {
        fetch(tree_.nodes + slot.node);
        continue;
      }
      done(slot.tag, *slot.sink);
      std::swap(which_[i], which_[--n_]);
    }
  }

  Slot& slot_of(int i) { return slots_[which_[i]]; }

  const WideView& tree_;
  int n_ = 0;
  std::vector<Slot> slots_;
  std::uint32_t which_[kSlots];  // the slots in use, then those that are free
  std::vector<std::uint32_t> leaf_, of_leaf_, ref_, of_ref_;
  std::vector<LeafPlace> place_;
};

}  // namespace fastlines
