// Divides a tree among threads: into subtrees, each a range of nodes in preorder, and the nodes above them.
#pragma once

#include <span>
#include <vector>

#include "tree.hpp"

namespace fastlines {

/// The nodes of one subtree.
struct SubtreeRange {
  std::uint32_t begin, end;
};

struct SubtreeRanges {
  std::vector<SubtreeRange> below;   ///< in preorder
  std::vector<std::uint32_t> above;  ///< all other nodes, parents before children
};

/// The largest subtrees of at most `max_nodes` nodes and `max_refs` references; a leaf may have more references.
inline SubtreeRanges subtree_ranges(std::span<const Node> nodes, std::size_t max_nodes, std::size_t max_refs) {
  SubtreeRanges ranges;
  std::vector<SubtreeRange> stack{{0, std::uint32_t(nodes.size())}};
  while (!stack.empty()) {
    const SubtreeRange range = stack.back();
    const Node& node = nodes[range.begin];
    stack.pop_back();
    if (node.is_leaf() || (range.end - range.begin <= max_nodes && node.n_refs <= max_refs)) {
      ranges.below.push_back(range);
      continue;
    }
    ranges.above.push_back(range.begin);
    stack.push_back({node.right, range.end});
    stack.push_back({range.begin + 1, node.right});
  }
  return ranges;
}

}  // namespace fastlines
