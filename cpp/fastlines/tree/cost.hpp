// The cost of a tree as a sum over its nodes: g of thesis §3.3, which equals f by Theorem 1.
#pragma once

#include <span>

#include "tree.hpp"

namespace fastlines {

/// The expected cost of a ray that hits the root. Each node counts with the chance that such a ray visits it.
inline double cost_of(std::span<const Node> nodes, double c_trav, double c_prim) {
  double cost = 0.0;
  for (const Node& node : nodes)
    cost += visit_chance(node.box, nodes[0].box) * (node.is_leaf() ? node.n_refs * c_prim : c_trav);
  return cost;
}

}  // namespace fastlines
