// The acceleration tree, as plain data (thesis §3).
//
// Nodes stand in preorder: the left child follows its parent, the right child is named, and both have larger indices
// than the parent. The references below a node are one range, so an inner node's primitive set needs no list of its
// own (Theorem 3).
#pragma once

#include <cstdint>

#include "../references/reference.hpp"

namespace fastlines {

struct Node {
  Box box;
  std::uint32_t right;      // index of the right child; 0 = this is a leaf
  std::uint32_t first_ref;  // the references at or below this node
  std::uint32_t n_refs;

  bool is_leaf() const { return right == 0; }
};
static_assert(sizeof(Node) == 36);

struct Tree {
  LargeVector<Node> nodes;
  LargeVector<Reference> refs;
};

}  // namespace fastlines
