// SPLITS of a build: the union of one or more split sets, tried in the order in which they are listed.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <variant>

#include "binned_planes.hpp"
#include "median.hpp"
#include "midpoint.hpp"
#include "object_sweep.hpp"
#include "overlap.hpp"
#include "plane_events.hpp"
#include "plane_grid.hpp"

namespace fastlines {

using SplitSet = std::variant<ObjectSweep, PlaneGrid, BinnedPlanes, PlaneEvents, Median, Midpoint>;
static_assert([]<class... Set>(std::type_identity<std::variant<Set...>>) {
  return (CandidateSet<Set> && ...);
}(std::type_identity<SplitSet>()));

/// A split set that is used only for some nodes.
struct SizedSplitSet {
  SplitSet set;
  std::size_t max_refs = std::size_t(-1);  ///< only nodes of at most this many references: |SPLITS| by size
  double min_overlap = 0.0;  ///< only where the children of the best object split so far overlap by a larger area
};

using Splits = std::vector<SizedSplitSet>;

/// Whether the boxes of planes may be off by rounding. The boxes of uncut splits and of object splits must be exact,
/// because the builder uses them as they are.
inline bool estimates(const Splits& splits) {
  return std::any_of(splits.begin(), splits.end(),
                     [](const SizedSplitSet& sized) { return std::holds_alternative<BinnedPlanes>(sized.set); });
}

/// The number of planes per axis that children inherit, except across the axis of the cut; 0 if SPLITS is not one grid.
inline int n_kept_planes(const Splits& splits) {
  if (splits.size() != 1) return 0;
  if (const auto* grid = std::get_if<PlaneGrid>(&splits[0].set)) return grid->n_planes;
  if (const auto* binned = std::get_if<BinnedPlanes>(&splits[0].set)) return binned->n_planes;
  return 0;
}

/// Pass the candidates for a node to `visitor`. `BinnedPlanes` offers only the cheapest of each axis, unless `all`.
template <Primitives P, class Visitor>
void visit_splits(const Splits& splits, const P& prims, Refs refs, const Box& box, BoxRule rule, const Measure& measure,
                  bool all, const Visitor& visitor) {
  const bool by_overlap = std::ranges::any_of(splits, [](const auto& sized) { return sized.min_overlap > 0.0; });
  Overlap overlap;
  const auto offer = [&](const Candidate& split) {
    if (by_overlap && split.kind == Candidate::Kind::objects) overlap.add(split);
    visitor(split);
  };
  for (const SizedSplitSet& sized : splits) {
    if (refs.size() > sized.max_refs || (sized.min_overlap > 0.0 && overlap.area() <= sized.min_overlap)) continue;
    std::visit(
        [&]<class Set>(const Set& set) {
          if (Set::kTightOnly && rule == BoxRule::cut) return;
          if constexpr (!std::same_as<Set, BinnedPlanes>)
            set.visit(prims, refs, box, rule, offer);
          else if constexpr (Straight<P>)
            set.visit(prims, refs, box, rule, measure, all, offer);
          else
            throw std::invalid_argument("BinnedPlanes needs primitives that are straight curves");
        },
        sized.set);
  }
}

/// Pass object splits for a node of any size to `visitor`. They come from split sets of object splits for which the
/// node has too many references, and from those that have a member `visit_uncut`. The caller must ignore planes.
template <Primitives P>
void visit_uncut(const Splits& splits, const P& prims, Refs refs, const Box& box, const Measure& measure,
                 CandidateVisitor visitor) {
  for (const SizedSplitSet& sized : splits)
    std::visit(
        [&]<class Set>(const Set& set) {
          if constexpr (Set::kTightOnly) {
            if (refs.size() > sized.max_refs) set.visit(prims, refs, box, BoxRule::tight, visitor);
          } else if constexpr (requires { set.visit_uncut(prims, refs, box, measure, visitor); }) {
            set.visit_uncut(prims, refs, box, measure, visitor);
          }
        },
        sized.set);
}

}  // namespace fastlines
