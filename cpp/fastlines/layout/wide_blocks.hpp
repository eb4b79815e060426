// The blocks of the wide BVH, and its references (wide_bvh.hpp).
#pragma once

#include <algorithm>
#include <cstdint>

#include "../references/reference.hpp"
#include "../simd/float_x1.hpp"

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

}  // namespace fastlines
