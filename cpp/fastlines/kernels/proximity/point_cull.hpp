// Culls the boxes of a node and the pieces of a leaf that lie beyond a distance of a point.
//
// Rounding may differ between instruction sets; both tests are conservative on all of them. The distance that is passed
// includes the eps of the point (query/proximity/point_query.hpp). With L = 1 + |p|∞, the exact test and the test of a
// leaf together are off by less than 2⁻²⁴·(31·L + 7), and eps is 2⁻²⁴·(32·L + 64).
#pragma once

#include <cstring>

#include "../../layout/leaf_bytes.hpp"
#include "../../layout/wide_bvh.hpp"
#include "../../query/proximity/point_query.hpp"
#include "../intersect/node_cull.hpp"

namespace fastlines {

/// The reach of boxes for a limit, which is negative inside thick lines. The boxes of an axis contain the whole ball
/// around a point inside; where shapes are cut, the point may be at the side of all boxes that have a part of it.
template <RayPrimitive P>
float box_reach(const PointQuery& query, float limit) {
  return AxisPrimitive<P> ? max(limit + query.eps, 0.0f) : max(limit, 0.0f) + query.eps;
}

/// A mask of the first n boxes of a block that a point may be within `reach` of, a distance in the frame. Sets `dist2`
/// to the squared distance of each.
template <class Block>
[[gnu::always_inline]] inline std::uint32_t cull_boxes(const Vec3& p, const Block& block, const std::uint8_t* planes,
                                                       unsigned n, float reach, FloatX16& dist2) {
  using F = FloatX16;
  const F scale = block.scale, zero = 0.0f;
  dist2 = zero;
  for (int k = 0; k < 3; ++k) {
    const float start = block.org[k] - p[k];
    const F below = fma(F::bytes(planes + k * kSimdWidth), scale, F(start));
    const F above = fnma(F::bytes(planes + (k + 3) * kSimdWidth), scale, F(-start));
    const F beyond = max(max(below, above), zero);
    dist2 = fma(beyond, beyond, dist2);
  }
  return (dist2 <= F(reach * reach)).bits() & ((1u << n) - 1);
}

/// The ends of a leaf's pieces along one axis, in quanta.
struct LeafAxis {
  FloatX16 a, c;

  /// `ends` are the 96 bytes of a leaf.
  [[gnu::always_inline]] static void load(const std::uint8_t* ends, LeafAxis (&to)[3]) {
    separate(ends, to[0].a, to[1].a);
    separate(ends + end_byte(0, 2, 0), to[2].a, to[2].c);
    separate(ends + end_byte(1, 0, 0), to[0].c, to[1].c);
  }

 private:
  /// The even and the odd ones of 32 bytes.
  [[gnu::always_inline]] static void separate(const std::uint8_t* pairs, FloatX16& even, FloatX16& odd) {
    typedef std::uint8_t Bytes __attribute__((vector_size(16)));
    Bytes low, high;
    std::memcpy(&low, pairs, sizeof low);
    std::memcpy(&high, pairs + sizeof low, sizeof high);
    const Bytes evens = __builtin_shufflevector(low, high, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const Bytes odds = __builtin_shufflevector(low, high, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    std::uint8_t bytes[2][kSimdWidth];
    std::memcpy(bytes[0], &evens, sizeof evens);
    std::memcpy(bytes[1], &odds, sizeof odds);
    even = FloatX16::bytes(bytes[0]);
    odd = FloatX16::bytes(bytes[1]);
  }
};

/// How far the ends of a leaf's pieces may be from where their bytes say, in quanta, and any point between them:
/// √3/2, and the rounding of the encoder.
inline constexpr float kAxisSlack = 0.89f;

/// A mask of the axes of a leaf that a point may be within `reach` of, a distance in the frame. If the surface counts,
/// the largest radius in the leaf is added to it.
[[gnu::always_inline]] inline std::uint32_t cull_axes(const Vec3& p, const WideLeaf& leaf, float reach, bool surface) {
  using F = FloatX16;
  const float radius = reach * leaf.inv_scale + kAxisSlack + (surface ? leaf.radius : 0.0f);
  LeafAxis axes[3];
  LeafAxis::load(leaf.ends, axes);
  F a[3], w[3], along = 0.0f, length2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    a[k] = axes[k].a - F((p[k] - leaf.org[k]) * leaf.inv_scale);
    w[k] = axes[k].c - axes[k].a;
    along = fnma(a[k], w[k], along);
    length2 = fma(w[k], w[k], length2);
  }
  // If a piece is a point, 0/0 clamps to an end of [0, 1].
  const F s = min(max(along / length2, F(0.0f)), F(1.0f));
  F dist2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const F r = fma(s, w[k], a[k]);
    dist2 = fma(r, r, dist2);
  }
  // Not a branch: no distance is below −1.
  const float radius2 = radius < 0.0f ? -1.0f : radius * radius;
  return (dist2 <= F(radius2)).bits() & ((1u << leaf.n_refs) - 1);
}

/// A mask of the pieces of a leaf that a point may be within a distance of.
template <RayPrimitive P>
[[gnu::always_inline]] inline std::uint32_t cull_pieces(const PointQuery& query, const WideLeaf& leaf, float limit) {
  if constexpr (!AxisPrimitive<P>) {
    FloatX16 dist2;
    if (!MixedPrimitive<P> || leaf.shape == LeafShape::boxes)
      return cull_boxes(query.p, leaf, leaf.ends, leaf.n_refs, box_reach<P>(query, limit), dist2);
  }
  return cull_axes(query.p, leaf, limit + query.eps, query.surface);
}

}  // namespace fastlines
