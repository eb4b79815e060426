// A tree dealt out to threads: subtrees that each stand in a row, as in preorder, and the nodes above them.
#pragma once

#include <span>
#include <vector>

#include "tree.hpp"

namespace fastlines {

struct Part {
  std::uint32_t begin, end;
};

struct Parts {
  std::vector<Part> below;
  std::vector<std::uint32_t> above;  // each before what is below it
};

/// Subtrees of so many nodes and references at most, or leaves.
inline Parts divide(std::span<const Node> nodes, std::size_t max_nodes, std::size_t max_refs) {
  Parts parts;
  std::vector<Part> stack{{0, std::uint32_t(nodes.size())}};
  while (!stack.empty()) {
    const Part part = stack.back();
    const Node& node = nodes[part.begin];
    stack.pop_back();
    if (node.is_leaf() || (part.end - part.begin <= max_nodes && node.n_refs <= max_refs)) {
      parts.below.push_back(part);
      continue;
    }
    parts.above.push_back(part.begin);
    stack.push_back({node.right, part.end});
    stack.push_back({part.begin + 1, node.right});
  }
  return parts;
}

}  // namespace fastlines
