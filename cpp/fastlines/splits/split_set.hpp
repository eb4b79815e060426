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

/// A split set that is asked only about some nodes.
struct SizedSplitSet {
  SplitSet set;
  std::size_t max_refs = std::size_t(-1);  ///< only those of at most so many references: |SPLITS| by size
  double min_overlap = 0.0;  ///< only where children of the best object split before it overlap in a larger area
};

using Splits = std::vector<SizedSplitSet>;

/// Whether the boxes of planes may be off by some roundings. Those of whole references and of objects have to be exact:
/// the builder takes them as they are.
inline bool estimates(const Splits& splits) {
  return std::any_of(splits.begin(), splits.end(),
                     [](const SizedSplitSet& sized) { return std::holds_alternative<BinnedPlanes>(sized.set); });
}

/// How many planes on each axis a node has of which its children have the same, but across the axis of the cut.
inline int n_kept_planes(const Splits& splits) {
  if (splits.size() != 1) return 0;
  if (const auto* grid = std::get_if<PlaneGrid>(&splits[0].set)) return grid->n_planes;
  if (const auto* octets = std::get_if<BinnedPlanes>(&splits[0].set)) return octets->n_planes;
  return 0;
}

/// Show the candidates for a node. Octets show only the cheapest of each axis unless `all` are asked for.
template <Primitives P, class Visitor>
void visit_splits(const Splits& splits, const P& prims, Refs refs, const Box& box, BoxRule rule, const Measure& measure,
                  bool all, Visitor&& visitor) {
  const bool by_overlap = std::ranges::any_of(splits, [](const auto& sized) { return sized.min_overlap > 0.0; });
  Overlap overlap;
  const auto show = [&](const Candidate& split) {
    if (by_overlap && split.kind == Candidate::Kind::objects) overlap.look_at(split);
    visitor(split);
  };
  for (const SizedSplitSet& sized : splits) {
    if (refs.size() > sized.max_refs || (sized.min_overlap > 0.0 && overlap.area() <= sized.min_overlap)) continue;
    std::visit(
        [&]<class Set>(const Set& set) {
          if constexpr (!std::same_as<Set, BinnedPlanes>)
            set.visit(prims, refs, box, rule, show);
          else if constexpr (Straight<P>)
            set.visit(prims, refs, box, rule, measure, all, show);
          else
            throw std::invalid_argument("octets of planes are for straight curves");
        },
        sized.set);
  }
}

/// Where no plane is allowed: whole splits of nodes of any size, by those sets that split small nodes whole.
template <Primitives P, class Visitor>
void visit_wholes(const Splits& splits, const P& prims, Refs refs, const Box& box, const Measure& measure,
                  Visitor&& visitor) {
  constexpr std::size_t any = std::size_t(-1);
  for (const SizedSplitSet& sized : splits) {
    if (std::holds_alternative<ObjectSweep>(sized.set) && refs.size() > sized.max_refs)
      ObjectSweep{}.visit(prims, refs, box, BoxRule::tight, visitor);
    if constexpr (Straight<P>)
      if (const auto* octets = std::get_if<BinnedPlanes>(&sized.set))
        if (octets->uncut_up_to > 0 || octets->gap_up_to > 0)
          BinnedPlanes{.n_planes = octets->n_planes, .uncut_up_to = any, .only_uncut_up_to = any}.visit(
              prims, refs, box, BoxRule::tight, measure, false, visitor);
  }
}

}  // namespace fastlines
