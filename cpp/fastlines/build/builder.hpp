// The builder (thesis §4.1). At each node it searches for the cheapest tree of a given depth over all candidate splits,
// applies the first split of that tree, and continues in the children. Depth 1 is SAH.
//
//   best_split(refs, box, 0) = leaf, cost n·c_prim (with SIMD lanes, n is `Measure::tests`)
//   best_split(refs, box, k) = the cheaper of the leaf and, over SPLITS,
//       c_trav + (SA(l)·best_split(l, k − 1) + SA(r)·best_split(r, k − 1)) / SA(box)
//
// Where long lines cross, the first levels of a good tree look worse than a leaf, and a shallow search never gets past
// them. So the builder may apply the best split on several such levels in a row, although the search prefers a leaf.
// When the subtree is finished, the builder compares its exact cost with that of a leaf. Each node chooses between leaf
// and children by the same cost, from the bottom up. So what remains is the cheapest pruning of the deep tree.
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
    try {
      root.build(std::move(refs), box, NodeContext{.spare = spare});
    } catch (const Cancelled&) {
      tasks_.rethrow();  // the error that cancelled the build, unless that was Ctrl-C
      throw;
    }
    limits_hit_ += root.limits_hit;
    searched_ = root.searched();
    return std::move(root.tree);
  }

  const LimitsHit& limits_hit() const { return limits_hit_; }
  const Searched& searched() const { return searched_; }

 private:
  /// `hull`, computed by all threads.
  Box hull_of(Refs refs) {
    constexpr std::size_t part = 1 << 14;  // references per task
    std::vector<Box> boxes((refs.size() + part - 1) / part);
    tasks_.for_ranges(0, boxes.size(), 1, [=, &boxes](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i)
        boxes[i] = hull(refs.subspan(i * part, std::min(part, refs.size() - i * part)));
    });
    BoxX4 all = BoxX4::empty();
    for (const Box& box : boxes) all.grow(BoxX4::load(box));
    return all.box();
  }

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  TaskGroup tasks_;
  LimitsHit limits_hit_;
  Searched searched_;
};

}  // namespace fastlines
