// Culls the leaves of a work list and lists the pieces that survive. Wavefront and RayStream share it.
#pragma once

#include "../intersect/node_cull.hpp"
#include "../intersect/prefetch.hpp"
#include "work_list.hpp"

namespace fastlines {

struct LeafSurvivorsTuning {
  /// Leaves culled before their survivors are listed. More leaves make longer runs of one test; fewer stay in the L1
  /// cache until they are listed.
  static constexpr std::size_t kBatch = 128;
  /// How many leaves ahead a leaf is prefetched, and how many offsets are computed before the first of their tests.
  static constexpr std::size_t kPrefetchDistance = kSimdWidth;
};

/// Work lists of (reference, ray) pairs, one list for each `rays_per_list` lanes. Lanes count from the first one of
/// their list.
template <int rays_per_list>
class LeafSurvivors {
 public:
  static constexpr int kLists = kGroupSize / rays_per_list;
  WorkList lists[kLists];

  void clear() {
    for (WorkList& list : lists) list.clear();
  }

  /// Cull each leaf of the list with its ray, and append the surviving pieces. Pads `leaf_list`. `tree` is passed by
  /// value, so that no store can alias it.
  template <RayPrimitive P>
  void add(WideBvhView<P> tree, WorkList& leaf_list, const CullRay* rays) {
    if (leaf_list.empty()) return;
    leaf_list.pad();  // prefetches read past the end
    const WideLeaf* const leaves = tree.leaves;
    const std::size_t n = leaf_list.size();
    for (std::size_t j = 0; j < kPrefetchDistance; ++j) prefetch(leaves + leaf_list.item[j]);
    for (std::size_t first = 0; first < n; first += kBatch) {
      const std::uint32_t *const leaf_ids = leaf_list.item.data() + first, *const ray = leaf_list.ray.data() + first;
      const std::size_t batch_size = std::min(n - first, kBatch);
      // Cull the leaves of the batch.
      for (std::size_t begin = 0; begin < batch_size; begin += kPrefetchDistance) {
        const std::size_t end = std::min(begin + kPrefetchDistance, batch_size);
        for (std::size_t j = begin; j < end; ++j)
          offsets_[j - begin] = leaf_offset<kHasRadius<P>>(leaves[leaf_ids[j]], rays[ray[j]].projected);
        for (std::size_t j = begin; j < end; ++j) {
          prefetch(leaves + leaf_ids[j + kPrefetchDistance]);
          survivor_masks_[j] = cull_pieces<P>(rays[ray[j]], leaves[leaf_ids[j]], offsets_[j - begin]);
        }
      }
      // List the survivors.
      WorkList::Appender appenders[kLists];
      for (int i = 0; i < kLists; ++i) appenders[i] = lists[i].appender(batch_size * kSimdWidth);
      for (std::size_t i = 0, n_hit = nonzero_indices(survivor_masks_, batch_size, hit_leaves_); i < n_hit; ++i) {
        const std::uint32_t j = hit_leaves_[i];
        const WideLeaf& leaf = leaves[leaf_ids[j]];
        prefetch_refs(tree, leaf);
        const std::uint32_t r = ray[j];
        if constexpr (kLists == 1)  // a constant index keeps the appender in registers
          appenders[0].compress(survivor_masks_[j], leaf.first_ref, r);
        else
          appenders[r / rays_per_list].compress(survivor_masks_[j], leaf.first_ref, r % rays_per_list);
      }
      for (int i = 0; i < kLists; ++i) lists[i].commit(appenders[i]);
    }
  }

 private:
  static constexpr std::size_t kBatch = LeafSurvivorsTuning::kBatch,
                               kPrefetchDistance = LeafSurvivorsTuning::kPrefetchDistance;
  static_assert(kBatch % kSimdWidth == 0);  // `nonzero_indices` reads and writes whole packets of the two arrays below

  LeafOffset offsets_[kPrefetchDistance];  // of the next leaves
  std::uint32_t survivor_masks_[kBatch];   // the surviving pieces of each leaf of a batch
  std::uint32_t hit_leaves_[kBatch];       // indices in the batch of the leaves with survivors
};

}  // namespace fastlines
