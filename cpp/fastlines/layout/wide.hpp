// The tree as the machine likes it: 16 children a node, boxes and pieces quantised to bytes, 128 bytes a block.
//
// A block has an origin and one scale for all three axes; a coordinate is org + q·scale, in the scene's frame. Children
// are in lanes: the inner ones first, then the leaves; both kinds stand in a row, so no child needs a pointer of its
// own.
//
// Blocks only cull. What survives is tested exactly, against the segment as the caller gave it.
#pragma once

#include <cstdint>

#include "../memory/buffer.hpp"
#include "../query/frame.hpp"
#include "../simd/simd.hpp"
#include "../tree/tree.hpp"

namespace fastlines {

struct alignas(128) WideNode {
  float org[3], scale;
  std::uint32_t first_inner, first_leaf;
  std::uint8_t n_inner, n_children;
  std::uint8_t unused[6];
  std::uint8_t planes[6 * kWidth];  // low x, y, z, then high x, y, z of all children, rounded outwards
};
static_assert(sizeof(WideNode) == 128);

struct alignas(128) WideLeaf {
  float org[3], scale;
  float per_scale;  // 1/scale
  std::uint32_t first_ref, n_refs;
  std::uint32_t unused;
  std::uint8_t ends[6 * kWidth];  // of each piece, rounded to nearest, as `end_byte` has them (simd/points.hpp)
};
static_assert(sizeof(WideLeaf) == 128);

struct WideTree {
  Frame frame;
  Box box;                   // of the scene, in the frame
  float mean_extent = 0.0f;  // of the leaves, in the frame
  Buffer<WideNode> nodes;
  Buffer<WideLeaf> leaves;
  Buffer<Reference> refs;  // in the order of the leaves

  std::size_t n_bytes() const {
    return nodes.size() * sizeof(WideNode) + leaves.size() * sizeof(WideLeaf) + refs.size() * sizeof(Reference);
  }
};

/// What a query sees of a wide tree: plain data.
struct WideView {
  Frame frame;
  Box box;
  float mean_extent;
  const WideNode* nodes;
  const WideLeaf* leaves;
  const Reference* refs;
  const Segment* segments;
};

inline WideView view_of(const WideTree& tree, const Segment* segments) {
  return {tree.frame, tree.box, tree.mean_extent, tree.nodes.data(), tree.leaves.data(), tree.refs.data(), segments};
}

}  // namespace fastlines
