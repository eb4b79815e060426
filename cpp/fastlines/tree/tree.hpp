// The tree, as plain data (thesis §3).
//
// Nodes are in preorder: the left child follows its parent, the right child is named by its index, and both have larger
// indices than the parent. The references below a node are one range, so an inner node needs no list of its primitives
// (Theorem 3).
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>

#include "../math/box.hpp"
#include "../memory/buffer.hpp"
#include "../references/reference.hpp"

namespace fastlines {

struct Node {
  Box box;
  std::uint32_t right;      ///< index of the right child; 0 for a leaf
  std::uint32_t first_ref;  ///< first reference at or below this node
  std::uint32_t n_refs;     ///< number of references at or below this node

  bool is_leaf() const { return right == 0; }
};
static_assert(sizeof(Node) == 36);

/// No node lies more than this many levels below the root. Only the builder recurses on the depth; traversal stacks
/// have one entry per level.
inline constexpr std::size_t kMaxDepth = 4096;

/// The index of no node.
inline constexpr std::uint32_t kNoNode = std::uint32_t(-1);

/// Nodes, and the references of all leaves in their order.
struct Tree {
  LargeVector<Node> nodes;
  LargeVector<Reference> refs;
};

/// Throws std::length_error if the counts of nodes and references exceed 32 bits.
inline void check_size(std::size_t n_nodes, std::size_t n_refs) {
  if (n_nodes >= 0xffff'fff0 || n_refs > 0xffff'fff0)
    throw std::length_error("a tree holds at most 2^32 nodes and references; set max_refs to less");
}

/// Append a subtree to the nodes of `tree`, and free it. Only the indices within the subtree are adjusted.
inline void append(Tree& tree, Tree&& other) {
  const std::size_t n_nodes = tree.nodes.size(), n_refs = tree.refs.size();
  check_size(n_nodes + other.nodes.size(), n_refs + other.refs.size());
  reserve_more(tree.nodes, other.nodes.size());
  append_moved(tree.nodes, std::move(other.nodes));
  for (Node& node : std::span(tree.nodes).subspan(n_nodes)) {
    if (!node.is_leaf()) node.right += std::uint32_t(n_nodes);
    node.first_ref += std::uint32_t(n_refs);
  }
  reserve_more(tree.refs, other.refs.size());
  append_moved(tree.refs, std::move(other.refs));
}

}  // namespace fastlines
