// SPLITS of a build: the union of one or more split sets, tried in the order in which they are listed.
#pragma once

#include <stdexcept>
#include <variant>

#include "median.hpp"
#include "middle.hpp"
#include "object_sweep.hpp"
#include "plane_events.hpp"
#include "plane_grid.hpp"
#include "plane_octets.hpp"

namespace fastlines {

using SplitSet = std::variant<ObjectSweep, PlaneGrid, PlaneOctets, PlaneEvents, Median, Middle>;

/// A split set that is asked only about nodes of at most so many references: |SPLITS| by size.
struct SizedSplitSet {
  SplitSet set;
  std::size_t max_refs = std::size_t(-1);
};

using Splits = std::vector<SizedSplitSet>;

/// Whether a candidate's boxes may be off by some roundings.
inline bool estimates(const Splits& splits) {
  return std::any_of(splits.begin(), splits.end(),
                     [](const SizedSplitSet& sized) { return std::holds_alternative<PlaneOctets>(sized.set); });
}

/// Show the candidates for a node. Octets measure boxes grown by `margin`, and show only the cheapest of each axis
/// unless `all` are asked for.
template <Primitives P, class Visitor>
void visit_splits(const Splits& splits, const P& prims, Refs refs, const Box& box, BoxRule rule, double margin,
                  bool all, Visitor&& visitor) {
  for (const SizedSplitSet& sized : splits) {
    if (refs.size() > sized.max_refs) continue;
    std::visit(
        [&]<class Set>(const Set& set) {
          if constexpr (!std::same_as<Set, PlaneOctets>)
            set.visit(prims, refs, box, rule, visitor);
          else if constexpr (Straight<P>)
            set.visit(prims, refs, box, rule, margin, all, visitor);
          else
            throw std::invalid_argument("octets of planes are for straight curves");
        },
        sized.set);
  }
}

}  // namespace fastlines
