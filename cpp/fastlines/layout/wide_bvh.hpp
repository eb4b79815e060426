// The layout that queries run on: a wide BVH with up to 16 children per node, whose boxes and pieces are quantised to
// bytes. A block, node or leaf, takes 128 bytes.
//
// A block has an origin and one scale for all three axes: a coordinate in the frame is org + q·scale, q in quanta. The
// children of a node are in lanes, inner ones first, then leaves. Children of a kind are contiguous in memory, so no
// child needs a pointer.
//
// Blocks only cull. Survivors are tested exactly, against the primitives as the caller gave them.
#pragma once

#include <algorithm>
#include <cstdint>

#include "../memory/buffer.hpp"
#include "../primitives/ray_primitive.hpp"
#include "../rays/frame.hpp"
#include "../simd/float_x16.hpp"
#include "../tree/tree.hpp"

namespace fastlines {

struct alignas(128) WideNode {
  float org[3], scale;                    ///< the grid, in the frame
  std::uint32_t first_inner, first_leaf;  ///< indices of the first child of each kind
  std::uint8_t n_inner, n_children;
  std::uint8_t unused[6];
  std::uint8_t planes[6 * kSimdWidth];  ///< low x, y, z, then high x, y, z of all children, rounded outwards
};
static_assert(sizeof(WideNode) == 128);

/// What a leaf stores of each piece: its axis, or its box.
enum class LeafShape : std::uint16_t { axes, boxes };

struct alignas(128) WideLeaf {
  float org[3], scale;  ///< the grid, in the frame
  float inv_scale;      ///< 1/scale
  std::uint32_t first_ref;
  std::uint16_t n_refs;
  LeafShape shape;
  float radius;  ///< the largest radius of its primitives, in quanta
  /// Axes: the ends of pieces, rounded to the nearest byte, in the order of `end_byte`. Boxes: as `WideNode::planes`.
  std::uint8_t ends[6 * kSimdWidth];
};
static_assert(sizeof(WideLeaf) == 128);

/// A reference in 8 bytes. Cuts are rounded, equally for the pieces on both sides, so pieces still tile their segment;
/// a piece may become empty. Boxes and ends of pieces are computed from the rounded cuts.
struct WideRef {
  std::uint32_t prim;
  std::uint16_t s0, s1;  ///< in 65536ths of the segment; the last piece ends at kOpen

  WideRef() = default;
  explicit WideRef(const Reference& ref) : prim(ref.prim), s0(rounded(ref.s0)), s1(rounded(ref.s1)) {}
  operator Reference() const { return {prim, begin(s0), end(s1)}; }

  /// The s at which a piece begins, from its s0.
  static float begin(std::uint32_t s) { return float(std::int32_t(s)) * 0x1p-16f; }
  /// The s at which a piece ends, from its s1; an open end lies beyond 1, where segments end.
  static float end(std::uint32_t s) { return begin(s + ((s + 1) & 0x10000)); }

 private:
  static constexpr std::uint16_t kOpen = 0xffff;
  static std::uint16_t rounded(float s) {
    if (!(s <= 1.0f)) return kOpen;
    return std::uint16_t(std::clamp(s * 0x1p16f + 0.5f, 0.0f, float(kOpen - 1)));
  }
};
static_assert(sizeof(WideRef) == 8);

/// A layout that owns its memory.
struct WideBvh {
  Frame frame;
  Box box;                   ///< of the scene, in the frame
  float mean_extent = 0.0f;  ///< of the leaves, in the frame
  Buffer<WideNode> nodes;
  Buffer<WideLeaf> leaves;
  Buffer<WideRef> refs;  ///< in the order of the leaves
};

/// A layout and its primitives as a query sees them: plain data.
template <RayPrimitive P>
struct WideBvhView {
  Frame frame;
  Box box;
  float mean_extent;
  const WideNode* nodes;
  const WideLeaf* leaves;
  const WideRef* refs;
  const typename P::Item* items;
};

/// The view of a layout. `box` is that of the tree, in the frame; it is grown by what the tree's boxes leave out.
template <RayPrimitive P>
WideBvhView<P> view_of(Frame frame, Box box, float mean_extent, const WideNode* nodes, const WideLeaf* leaves,
                       const WideRef* refs, const P& prims) {
  if constexpr (kHasRadius<P>) {
    const float max_radius = max_radius_of(prims) * frame.scale;
    frame.overhang += max_radius * kRadiusRounding;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] -= max_radius;
      box.hi[k] += max_radius;
    }
  }
  return {frame, box, mean_extent, nodes, leaves, refs, prims.items()};
}

template <RayPrimitive P>
WideBvhView<P> view_of(const WideBvh& tree, const P& prims) {
  return view_of(tree.frame, tree.box, tree.mean_extent, tree.nodes.data(), tree.leaves.data(), tree.refs.data(),
                 prims);
}

}  // namespace fastlines
