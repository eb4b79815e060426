// SPLITS of a build: the union of one or more split sets, tried in the order in which they are listed.
#pragma once

#include <variant>

#include "median.hpp"
#include "middle.hpp"
#include "object_sweep.hpp"
#include "plane_events.hpp"
#include "plane_grid.hpp"

namespace fastlines {

using SplitSet = std::variant<ObjectSweep, PlaneGrid, PlaneEvents, Median, Middle>;

/// A split set that is asked only about nodes of at most so many references: |SPLITS| by size.
struct SizedSplitSet {
  SplitSet set;
  std::size_t max_refs = std::size_t(-1);
};

using Splits = std::vector<SizedSplitSet>;

template <Primitives P, class Visitor>
void visit_splits(const Splits& splits, const P& prims, Refs refs, const Box& box, BoxRule rule, Visitor&& visitor) {
  for (const SizedSplitSet& sized : splits)
    if (refs.size() <= sized.max_refs)
      std::visit([&](const auto& set) { set.visit(prims, refs, box, rule, visitor); }, sized.set);
}

}  // namespace fastlines
