// Trees as arrays, and builds that return them.
#pragma once

#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "fastlines/build/builder.hpp"
#include "watch.hpp"

namespace fastlines {

/// Nodes or references as rows of 32-bit words.
using WordRows = Output<std::uint32_t>;

/// Nodes; references; the number of nodes that each limit affected (depth, references, references of a leaf); and the
/// numbers of candidates that searches with lookahead considered and carried out.
using BuiltTree = std::tuple<WordRows, WordRows, std::tuple<std::size_t, std::size_t, std::size_t>,
                             std::tuple<std::size_t, std::size_t>>;

template <Primitives P>
BuiltTree build_tree(const P& prims, Settings settings, const nanobind::object& progress) {
  Tree tree;
  LimitsHit hit;
  SearchCounts search_counts;
  watch(
      [&](Progress& watched) {
        for (SizedSplitSet& sized : settings.splits)
          if (sized.min_overlap > 0.0) sized.min_overlap *= bounds_of_all(prims).area();
        Builder builder(prims, settings, watched);
        tree = builder.build();
        hit = builder.limits_hit();
        search_counts = builder.search_counts();
      },
      progress);
  return {adopt<std::uint32_t>(std::move(tree.nodes)),
          adopt<std::uint32_t>(std::move(tree.refs)),
          {hit.depth, hit.refs, hit.leaf_refs},
          {search_counts.candidates, search_counts.partitioned}};
}

/// A pass over more nodes or references than this is watched for Ctrl-C.
inline constexpr std::size_t kLongPass = 1'000'000;

}  // namespace fastlines
