// The layout that queries run on: a wide BVH with up to 16 children per node, whose boxes and pieces are quantised to
// bytes. A block, node or leaf, takes 128 bytes.
//
// A block has an origin and one scale for all three axes: a coordinate in the frame is org + q·scale, q in quanta. The
// children of a node are in lanes, inner ones first, then leaves. Children of a kind are contiguous in memory, so no
// child needs a pointer.
//
// Blocks only cull. Survivors are tested exactly, against the primitives as the caller gave them.
#pragma once

#include "../memory/buffer.hpp"
#include "../primitives/ray_primitive.hpp"
#include "../rays/frame_of.hpp"
#include "../simd/float_x16.hpp"
#include "../tree/tree.hpp"
#include "wide_blocks.hpp"

namespace fastlines {

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
