// Finds the primitives in a region on the wide layout.
//
// Blocks are culled in the frame, by a region that is grown by more than all rounding: that of coordinates to the
// frame, at most 2⁻²³, of the boxes of the tree, and of the arithmetic here. Survivors are tested exactly. If the box
// of a piece of an axis lies within the region that is shrunk by as much, the piece is in the region and needs no test.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "../../layout/leaf_bytes.hpp"
#include "../../layout/wide_bvh.hpp"
#include "../../query/proximity/in_box.hpp"

namespace fastlines {

/// A region prepared for culling, in the frame.
struct CullRegion {
  float lo[3], hi[3];              ///< grown
  float inner_lo[3], inner_hi[3];  ///< shrunk

  CullRegion(const Region& region, const Frame& frame) {
    constexpr double far = 1e37;  // beyond all primitives
    const double rounding = 0x1p-18 + 2.0 * frame.overhang;
    for (int k = 0; k < 3; ++k) {
      const auto in_frame = [&](double x) { return std::clamp((x - frame.centre[k]) * frame.scale, -far, far); };
      const double low = in_frame(region.lo[k]), high = in_frame(region.hi[k]);
      const double at_low = rounding + 0x1p-20 * std::abs(low), at_high = rounding + 0x1p-20 * std::abs(high);
      lo[k] = float(low - at_low);
      hi[k] = float(high + at_high);
      inner_lo[k] = float(low + at_low);
      inner_hi[k] = float(high - at_high);
    }
  }
};

/// Masks of the first n boxes of a block: those that may share a point with a region, and those that lie within it.
struct BoxesInRegion {
  std::uint32_t near, inside;

  template <class Block>
  BoxesInRegion(const CullRegion& region, const Block& block, const std::uint8_t* planes, unsigned n) {
    using F = FloatX16;
    near = inside = (1u << n) - 1;
    for (int k = 0; k < 3; ++k) {
      const F low = fma(F::bytes(planes + k * kSimdWidth), F(block.scale), F(block.org[k]));
      const F high = fma(F::bytes(planes + (k + 3) * kSimdWidth), F(block.scale), F(block.org[k]));
      near &= ((low <= F(region.hi[k])) & (F(region.lo[k]) <= high)).bits();
      inside &= ((F(region.inner_lo[k]) <= low) & (high <= F(region.inner_hi[k]))).bits();
    }
  }
};

/// A mask of the pieces of a leaf of axes that may be in a region. Ends are rounded to the nearest byte.
inline std::uint32_t cull_axes(const CullRegion& region, const WideLeaf& leaf) {
  std::uint32_t near = (1u << leaf.n_refs) - 1;
  const float slack = 1.0f + leaf.radius;  // quanta
  for (int k = 0; k < 3; ++k) {
    const float low = (region.lo[k] - leaf.org[k]) * leaf.inv_scale - slack;
    const float high = (region.hi[k] - leaf.org[k]) * leaf.inv_scale + slack;
    for (int i = 0; i < leaf.n_refs; ++i) {
      const int a = leaf.ends[end_byte(0, k, i)], c = leaf.ends[end_byte(1, k, i)];
      if (float(std::max(a, c)) < low || float(std::min(a, c)) > high) near &= ~(1u << i);
    }
  }
  return near;
}

/// Searches the tree for the primitives in a region; `list_in_boxes` calls it.
template <RayPrimitive P>
class InBoxSearch {
 public:
  InBoxSearch(const WideBvhView<P>& tree, bool surface) : tree_(tree), surface_(surface) {}

  void operator()(const Region& region, Ids& ids, Checkpoint& checkpoint) {
    const CullRegion cull(region, tree_.frame);
    waiting_.assign(1, {0, false});
    while (!waiting_.empty()) {
      const auto [index, all] = waiting_.back();
      waiting_.pop_back();
      const WideNode& node = tree_.nodes[index];
      const BoxesInRegion boxes(cull, node, node.planes, node.n_children);
      std::uint32_t near = all ? (1u << node.n_children) - 1 : boxes.near;
      checkpoint.pass(std::uint64_t(std::popcount(near >> node.n_inner)));
      for (; near; near &= near - 1) {
        const auto lane = std::uint32_t(std::countr_zero(near));
        // Only around an axis is the box of a piece surely that of something in the primitive.
        const bool is_inside = all || (AxisPrimitive<P> && (boxes.inside >> lane & 1));
        if (lane < node.n_inner)
          waiting_.push_back({node.first_inner + lane, is_inside});
        else
          list_leaf(tree_.leaves[node.first_leaf + (lane - node.n_inner)], is_inside, cull, ids);
      }
      for (const std::uint32_t prim : survivors_)
        if (is_in(region, tree_.items[prim], surface_)) ids.push_back(prim);
      survivors_.clear();
    }
  }

 private:
  struct Entry {
    std::uint32_t node;
    bool is_inside;
  };

  /// List the primitives of a leaf that is inside, or those that may be in the region; the caller tests these.
  void list_leaf(const WideLeaf& leaf, bool is_inside, const CullRegion& cull, Ids& ids) {
    std::uint32_t near = is_inside ? (1u << leaf.n_refs) - 1 : cull_leaf(leaf, cull);
    for (; near; near &= near - 1) {
      const std::uint32_t prim = tree_.refs[leaf.first_ref + std::uint32_t(std::countr_zero(near))].prim;
      if (!is_inside) __builtin_prefetch(tree_.items + prim);
      (is_inside ? ids : survivors_).push_back(prim);
    }
  }

  static std::uint32_t cull_leaf(const WideLeaf& leaf, const CullRegion& cull) {
    if (leaf.shape == LeafShape::boxes) return BoxesInRegion(cull, leaf, leaf.ends, leaf.n_refs).near;
    return cull_axes(cull, leaf);
  }

  const WideBvhView<P>& tree_;
  bool surface_;
  std::vector<Entry> waiting_;  // nodes
  Ids survivors_;               // of the leaves of a node, to be tested
};

}  // namespace fastlines
