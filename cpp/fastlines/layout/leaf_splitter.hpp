// Splits leaves that list more references than a block holds, so that any tree can be laid out.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../parallel/progress.hpp"
#include "../splits/candidate.hpp"
#include "../tree/tree.hpp"
#include "piece_box.hpp"

namespace fastlines {

/// Copies a tree, with its large leaves replaced by subtrees.
template <RayPrimitive P>
class LeafSplitter {
 public:
  LeafSplitter(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims, std::size_t max_refs,
               const Progress& progress)
      : nodes_(nodes), refs_(refs), prims_(prims), max_refs_(max_refs), progress_(progress) {}

  Tree operator()() {
    tree_.refs.reserve(refs_.size());
    std::vector<std::uint32_t> new_index(nodes_.size());  // the index of each node in the new tree
    for (std::size_t v = 0; v < nodes_.size(); ++v) {
      if (v % 4096 == 0) progress_.check();
      const Node& node = nodes_[v];
      new_index[v] = std::uint32_t(tree_.nodes.size());
      if (node.is_leaf() && node.n_refs > max_refs_) {
        split(node);
      } else {
        tree_.nodes.push_back(node);
        if (node.is_leaf()) append(refs_.subspan(node.first_ref, node.n_refs));
      }
    }
    for (std::size_t v = 0; v < nodes_.size(); ++v)
      if (!nodes_[v].is_leaf()) tree_.nodes[new_index[v]].right = new_index[nodes_[v].right];
    return std::move(tree_);
  }

 private:
  /// References that become a subtree, and the node whose right child it becomes: `kNoNode` for the root and left
  /// children.
  struct Subtree {
    std::span<BuildRef> refs;
    Box box;
    std::uint32_t parent = kNoNode;
  };

  /// Split a leaf recursively at the median centre along the longest axis.
  void split(const Node& leaf) {
    std::vector<BuildRef> all;
    for (const Reference& ref : refs_.subspan(leaf.first_ref, leaf.n_refs))
      all.push_back({ref, box_of_piece(prims_, ref, leaf.box)});
    std::vector<Subtree> stack{{all, leaf.box}};
    while (!stack.empty()) {
      const auto [below, box, parent] = stack.back();
      stack.pop_back();
      progress_.check();
      const auto index = std::uint32_t(tree_.nodes.size());
      if (parent != kNoNode) tree_.nodes[parent].right = index;
      tree_.nodes.push_back({box, 0, std::uint32_t(tree_.refs.size()), std::uint32_t(below.size())});
      if (below.size() <= max_refs_) {
        for (const BuildRef& ref : below) tree_.refs.push_back(ref.ref);
        continue;
      }
      const auto middle = below.begin() + std::ptrdiff_t(below.size() / 2);
      std::nth_element(below.begin(), middle, below.end(), ByCentre{box.longest_axis()});
      const std::span<BuildRef> left(below.begin(), middle), right(middle, below.end());
      stack.push_back({right, hull(right), index});
      stack.push_back({left, hull(left)});
    }
  }

  /// Append references to the new tree.
  void append(std::span<const Reference> refs) { tree_.refs.insert(tree_.refs.end(), refs.begin(), refs.end()); }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  P prims_;
  std::size_t max_refs_;
  const Progress& progress_;
  Tree tree_;
};

/// The tree with each leaf of more than `max_refs` references split.
template <RayPrimitive P>
Tree split_large_leaves(std::span<const Node> nodes, std::span<const Reference> refs, const P& prims,
                        std::size_t max_refs, const Progress& progress) {
  return LeafSplitter(nodes, refs, prims, max_refs, progress)();
}

}  // namespace fastlines
