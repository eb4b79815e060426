// The same tree over lines that have moved.
#pragma once

#include "engine.hpp"
#include "fastlines/build/refit.hpp"
#include "fastlines/tree/cost.hpp"
#include "line_input.hpp"

namespace fl::detail {

/// Fits the boxes of a tree over `before` to `items`, and records that in its origin.
template <class Item>
fastlines::Tree moved_tree(const fastlines::Tree& tree, const std::vector<Item>& before, const std::vector<Item>& items,
                           TreeOrigin& origin, unsigned n_threads, fastlines::Progress& progress) {
  fastlines::Tree moved{fastlines::LargeVector<fastlines::Node>(tree.nodes.size()), tree.refs};
  const auto fit = [&](const std::vector<Item>& to) {
    const auto axes = axes_of(std::span<const Item>(to));
    fastlines::Refit<fastlines::Segments>(tree.nodes, tree.refs, fastlines::Segments{axes}, moved.nodes.data())(
        n_threads, progress);
  };
  if (!origin.built_cost) {
    // The growth of a refitted tree is relative to its cost with tight boxes.
    if (origin.is_cut) fit(before);
    origin.built_cost = fastlines::cost_of(origin.is_cut ? moved.nodes : tree.nodes, origin.c_trav, origin.c_prim);
  }
  fit(items);
  origin.be_tight();
  return moved;
}

}  // namespace fl::detail
