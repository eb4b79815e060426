// The leaves that rays have met, and the pieces in them that survive culling: what a wave and a stream have in common.
#pragma once

#include "cull.hpp"
#include "fetch.hpp"
#include "pairs.hpp"

namespace fastlines {

/// Pairs of a reference and a ray, a list for each `together` rays, of which it counts them.
template <int together>
class Survivors {
 public:
  static constexpr int kLists = kLanes / together;
  Pairs lists[kLists];

  void clear() {
    for (Pairs& list : lists) list.clear();
  }

  /// Append what survives of the pieces of these leaves, each for its ray. The tree is a copy, so that nothing written
  /// can alias it.
  void add(WideView tree, Pairs& met, const CullRay* rays) {
    if (met.empty()) return;
    met.pad();  // so that what is fetched ahead is there
    const WideLeaf* const leaves = tree.leaves;
    const std::size_t n = met.size();
    for (std::size_t j = 0; j < kAhead; ++j) fetch(leaves + met.what[j]);
    for (std::size_t first = 0; first < n; first += kSome) {
      const std::uint32_t *const what = met.what.data() + first, *const ray = met.ray.data() + first;
      const std::size_t some = std::min(n - first, kSome);
      for (std::size_t begin = 0; begin < some; begin += kAhead) {
        const std::size_t end = std::min(begin + kAhead, some);
        for (std::size_t j = begin; j < end; ++j) places_[j - begin] = place_of(leaves[what[j]], rays[ray[j]].across);
        for (std::size_t j = begin; j < end; ++j) {
          fetch(leaves + what[j + kAhead]);
          near_[j] = cull_leaf(rays[ray[j]].across, leaves[what[j]], places_[j - begin]);
        }
      }
      Pairs::Tail tails[kLists];
      for (int i = 0; i < kLists; ++i) tails[i] = lists[i].tail(some * kWidth);
      for (std::size_t i = 0, n_met = pack_set(near_, some, met_); i < n_met; ++i) {
        const std::uint32_t j = met_[i];
        const WideLeaf& leaf = leaves[what[j]];
        fetch_refs(tree, leaf);
        const std::uint32_t r = ray[j];
        if constexpr (kLists == 1)  // else the one tail that there is would not stay in registers
          tails[0].pack(near_[j], leaf.first_ref, r);
        else
          tails[r / together].pack(near_[j], leaf.first_ref, r % together);
      }
      for (int i = 0; i < kLists; ++i) lists[i].end(tails[i]);
    }
  }

 private:
  static constexpr std::size_t kSome = 128, kAhead = kWidth;
  static_assert(kSome % kWidth == 0);  // so that sixteens are read and written within what there is

  LeafPlace places_[kAhead];  // of some leaves
  // The pieces of each of some leaves that survive; those of which any does.
  std::uint32_t near_[kSome], met_[kSome];
};

}  // namespace fastlines
