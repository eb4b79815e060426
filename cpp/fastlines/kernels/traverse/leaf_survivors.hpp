// The leaves that rays have met, and the pieces in them that survive culling: what a wave and a stream have in common.
#pragma once

#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"
#include "work_list.hpp"

namespace fastlines {

/// WorkList of a reference and a ray, a list for each `together` rays, of which it counts them.
template <int together>
class LeafSurvivors {
 public:
  static constexpr int kLists = kGroupSize / together;
  WorkList lists[kLists];

  void clear() {
    for (WorkList& list : lists) list.clear();
  }

  /// Append what survives of the pieces of these leaves, each for its ray. The tree is a copy, so that nothing written
  /// can alias it.
  template <RayPrimitive P>
  void add(WideBvhView<P> tree, WorkList& met, const CullRay* rays) {
    if (met.empty()) return;
    met.pad();  // so that what is fetched ahead is there
    const WideLeaf* const leaves = tree.leaves;
    const std::size_t n = met.size();
    for (std::size_t j = 0; j < kPrefetchDistance; ++j) prefetch(leaves + met.what[j]);
    for (std::size_t first = 0; first < n; first += kBatch) {
      const std::uint32_t *const what = met.what.data() + first, *const ray = met.ray.data() + first;
      const std::size_t some = std::min(n - first, kBatch);
      for (std::size_t begin = 0; begin < some; begin += kPrefetchDistance) {
        const std::size_t end = std::min(begin + kPrefetchDistance, some);
        for (std::size_t j = begin; j < end; ++j)
          places_[j - begin] = leaf_offset<P::kHasRadius>(leaves[what[j]], rays[ray[j]].across);
        for (std::size_t j = begin; j < end; ++j) {
          prefetch(leaves + what[j + kPrefetchDistance]);
          near_[j] = cull_leaf(rays[ray[j]].across, leaves[what[j]], places_[j - begin]);
        }
      }
      WorkList::Appender appenders[kLists];
      for (int i = 0; i < kLists; ++i) appenders[i] = lists[i].appender(some * kSimdWidth);
      for (std::size_t i = 0, n_met = nonzero_indices(near_, some, met_); i < n_met; ++i) {
        const std::uint32_t j = met_[i];
        const WideLeaf& leaf = leaves[what[j]];
        prefetch_refs(tree, leaf);
        const std::uint32_t r = ray[j];
        if constexpr (kLists == 1)  // else the one tail that there is would not stay in registers
          appenders[0].compress(near_[j], leaf.first_ref, r);
        else
          appenders[r / together].compress(near_[j], leaf.first_ref, r % together);
      }
      for (int i = 0; i < kLists; ++i) lists[i].end(appenders[i]);
    }
  }

 private:
  static constexpr std::size_t kBatch = 128, kPrefetchDistance = kSimdWidth;
  static_assert(kBatch % kSimdWidth == 0);  // so that sixteens are read and written within what there is

  LeafOffset places_[kPrefetchDistance];  // of some leaves
  // The pieces of each of some leaves that survive; those of which any does.
  std::uint32_t near_[kBatch], met_[kBatch];
};

}  // namespace fastlines
