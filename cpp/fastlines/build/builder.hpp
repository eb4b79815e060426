// The builder (thesis §4.1). At each node it searches for the cheapest tree of a given depth over all candidate splits,
// applies the first split of that tree, and continues in the children. Depth 1 is SAH.
//
//   best_split(refs, box, 0) = leaf, cost n·c_prim (with SIMD lanes, n is `Measure::tests`)
//   best_split(refs, box, k) = the cheaper of the leaf and, over SPLITS,
//       c_trav + (SA(l)·best_split(l, k − 1) + SA(r)·best_split(r, k − 1)) / SA(box)
//
// Where long lines cross, the first levels of a good tree look worse than a leaf, and a shallow search never gets past
// them. So the builder may apply the best split on several such levels in a row, although the search prefers a leaf.
// When a subtree is finished, the builder compares its exact cost with that of a leaf, and keeps the cheaper one. This
// is done from the bottom up, so the result is the cheapest pruning of the deep tree.
#pragma once

#include "node_builder.hpp"

namespace fastlines {

/// Builds one tree. `build` may be called once; the statistics are those of that build.
template <Primitives P>
class Builder {
 public:
  Builder(const P& prims, const Settings& settings, Progress& progress)
      : prims_(prims), settings_(settings), progress_(progress), tasks_(settings.n_threads) {}

  Tree build() {
    Buffer<BuildRef> refs = first_references(prims_, settings_.presplit, tasks_, progress_, limits_hit_.refs);
    Box box = hull_of(refs);
    if (refs.size() == 0) box = Box{{0, 0, 0}, {0, 0, 0}};
    NodeBuilder<P> root(prims_, settings_, progress_, tasks_, box.side(box.longest_axis()));
    if (refs.size() > root.capacity(0))
      throw std::invalid_argument("max_leaf_refs and max_depth leave no room for all references");
    if (refs.size() > settings_.limits.max_refs)
      throw std::invalid_argument("max_refs is less than the number of primitives");
    const std::size_t spare = settings_.limits.max_refs - refs.size();
    const struct AtEnd {
      ~AtEnd() { PagePool::shrink(kKeptBytes); }
    } at_end;
    try {
      root.build(std::move(refs), box, NodeContext{.spare = spare});
    } catch (const Cancelled&) {
      tasks_.rethrow();  // the error that cancelled the build, unless the watcher did
      throw;
    }
    limits_hit_ += root.limits_hit;
    search_counts_ = root.search_counts();
    return std::move(root.tree);
  }

  const LimitsHit& limits_hit() const { return limits_hit_; }
  const SearchCounts& search_counts() const { return search_counts_; }

 private:
  /// `hull`, computed by all threads.
  Box hull_of(Refs refs) {
    constexpr std::size_t per_task = 1 << 14;  // references
    std::vector<Box> boxes((refs.size() + per_task - 1) / per_task);
    tasks_.for_ranges(0, boxes.size(), 1, [=, &boxes](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i)
        boxes[i] = hull(refs.subspan(i * per_task, std::min(per_task, refs.size() - i * per_task)));
    });
    BoxX4 all = BoxX4::empty();
    for (const Box& box : boxes) all.grow(BoxX4::load(box));
    return all.box();
  }

  /// Memory kept for the next build, in bytes: as much as that of a million references takes. All else is returned.
  static constexpr std::size_t kKeptBytes = std::size_t(1) << 26;

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  TaskGroup tasks_;
  LimitsHit limits_hit_;
  SearchCounts search_counts_;
};

}  // namespace fastlines
