// A KD tree stored as its planes (thesis §1.2.2): an inner node is an axis and a plane, not two boxes.
//
// Siblings are adjacent, the lower half first, so that a step down reads one cache line. A block of two cache lines
// holds a subtree. Nodes are added to it in decreasing order of surface area, which is proportional to the chance of a
// visit.
#pragma once

#include <algorithm>
#include <bit>
#include <span>

#include "../parallel/progress.hpp"
#include "../rays/frame_of.hpp"
#include "../tree/tree.hpp"
#include "slabs.hpp"

namespace fastlines {

/// A node of a KD tree in eight bytes.
struct PlaneNode {
  static constexpr std::uint32_t kLeaf = 3, kShift = 2;

  /// Inner node: the bits of its plane, in the frame. Leaf: its first reference, or the primitive if it has just one.
  std::uint32_t word = 0;
  /// High bits: the index of the pair of children, or the number of references. Low two bits: the axis, or kLeaf.
  std::uint32_t link = kLeaf;

  static PlaneNode inner(int axis, float plane, std::size_t pair) {
    return {std::bit_cast<std::uint32_t>(plane), std::uint32_t(pair) << kShift | std::uint32_t(axis)};
  }
  static PlaneNode leaf(const Node& leaf, std::span<const Reference> refs) {
    const std::uint32_t word = leaf.n_refs == 1 ? refs[leaf.first_ref].prim : leaf.first_ref;
    return {word, leaf.n_refs << kShift | kLeaf};
  }

  bool is_leaf() const { return (link & kLeaf) == kLeaf; }
  bool is_empty() const { return link == kLeaf; }
  int axis() const { return int(link & kLeaf); }
  float plane() const { return std::bit_cast<float>(word); }
  std::uint32_t lower_child() const { return link >> kShift << 1; }
  std::uint32_t n_refs() const { return link >> kShift; }
};
static_assert(sizeof(PlaneNode) == 8);

/// The nodes of a KD tree, and the primitive of each reference.
struct PlaneTree {
  /// Pairs of siblings in a block of two cache lines.
  static constexpr std::size_t kBlockPairs = 8;
  static constexpr std::size_t kMaxCount = std::size_t(1) << (32 - PlaneNode::kShift);

  LargeVector<PlaneNode> nodes;  ///< the first is the root; the second is unused
  LargeVector<std::uint32_t> prims;
  std::uint32_t depth = 0;
};

/// The axis along which a node is split, from the boxes of the node and of its children.
inline int cut_axis(const Box& box, const Box& left, const Box& right) {
  int axis = 0;
  while (axis < 2 && left.hi[axis] == box.hi[axis] && right.lo[axis] == box.lo[axis]) ++axis;
  return axis;
}

/// Converts a KD tree to planes. Precondition: `check_usable` accepts the tree.
class PlaneTreeWriter {
 public:
  PlaneTreeWriter(std::span<const Node> nodes, std::span<const Reference> refs, const Frame& frame)
      : nodes_(nodes), refs_(refs), frame_(frame) {}

  PlaneTree operator()(Progress& progress) {
    if (refs_.size() >= PlaneTree::kMaxCount) refuse();
    PlaneTree to;
    to.nodes.reserve(nodes_.size() + nodes_.size() / 2);
    to.nodes.resize(2);
    to.prims.resize(refs_.size());
    std::ranges::transform(refs_, to.prims.begin(), &Reference::prim);
    std::vector<Open> waiting;  // the roots of later blocks
    add({0, 0, 0}, to, waiting);
    for (std::size_t n_blocks = 0; !waiting.empty(); ++n_blocks) {
      if (n_blocks % 1024 == 0) progress.check();
      open_.assign(1, waiting.back());
      waiting.pop_back();
      write_block(to);
      // Sort the nodes that do not fit into the block, so that the largest comes next.
      std::ranges::sort(open_, {}, [this](const Open& open) { return area(open); });
      waiting.insert(waiting.end(), open_.begin(), open_.end());
    }
    return to;
  }

 private:
  /// An inner node whose children are not written yet, its index among the planes, and its depth.
  struct Open {
    std::uint32_t node;
    std::size_t to;
    std::uint32_t depth;
  };

  [[noreturn]] static void refuse() {
    throw std::length_error(
        "a search by planes takes fewer than 2^30 references and pairs of nodes; use another kernel");
  }

  double area(const Open& open) const { return nodes_[open.node].box.area(); }

  /// Fill a block with nodes below the open one. Nodes that do not fit stay open.
  void write_block(PlaneTree& to) {
    std::size_t next = to.nodes.size() == 2 ? 2 : round_up(to.nodes.size());
    const std::size_t end = round_up(next + 1);
    if (end > 2 * PlaneTree::kMaxCount) refuse();
    to.nodes.resize(end);
    for (; next < end && !open_.empty(); next += 2) {
      const auto largest = std::ranges::max_element(open_, {}, [this](const Open& open) { return area(open); });
      const Open parent = *largest;
      open_.erase(largest);
      const std::uint32_t left = parent.node + 1, right = nodes_[parent.node].right;
      const int axis = cut_axis(nodes_[parent.node].box, nodes_[left].box, nodes_[right].box);
      const float plane = Slabs::in_frame(frame_, axis, nodes_[left].box.hi[axis]);
      to.nodes[parent.to] = PlaneNode::inner(axis, plane, next / 2);
      add({left, next, parent.depth + 1}, to, open_);
      add({right, next + 1, parent.depth + 1}, to, open_);
    }
    to.nodes.resize(next);
  }

  /// Write a leaf, or add an inner node to `open`.
  void add(const Open& node, PlaneTree& to, std::vector<Open>& open) const {
    to.depth = std::max(to.depth, node.depth);
    if (nodes_[node.node].is_leaf())
      to.nodes[node.to] = PlaneNode::leaf(nodes_[node.node], refs_);
    else
      open.push_back(node);
  }

  static std::size_t round_up(std::size_t n_nodes) {
    constexpr std::size_t block = 2 * PlaneTree::kBlockPairs;
    return (n_nodes + block - 1) / block * block;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  Frame frame_;
  std::vector<Open> open_;  // in the current block
};

}  // namespace fastlines
