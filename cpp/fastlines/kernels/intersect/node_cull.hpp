// A ray prepared for culling, and the test of a ray against the 16 boxes of a node or of a leaf. The test against the
// 16 axes of a leaf is in leaf_cull.hpp.
//
// Rounding may differ between instruction sets; both tests are conservative on all of them.
#pragma once

#include <bit>

#include "../rays/ray_group.hpp"
#include "leaf_cull.hpp"

namespace fastlines {

/// A ray, or the axis of a bundle, prepared for culling: its line and its culling radius, in the frame. N is float, or
/// FloatX16 for a packet. Fields are groups of four values, so that a 16×4 transpose turns a packet into 16 rays.
template <class N>
struct alignas(64) CullRayOf {
  N inverse[4], near[4], far[4];  // t of a near plane: q·(scale·inverse) + (org·inverse + near); [3] is padding
  N near_rows, far_rows;          // offsets of the near and far rows in WideNode::planes, a byte each for x, y and z
  N t_min, unused;
  ProjectedRayOf<N> projected;  // for leaf culling

  CullRayOf() = default;
  CullRayOf(const N (&o)[3], const N (&r)[3], const N (&u)[3], const N (&v)[3], N cull_radius, N t_min_)
      : near_rows(kRows), far_rows(kRows), t_min(t_min_), unused(0.0f), projected(o, r, u, v, cull_radius) {
    inverse[3] = near[3] = far[3] = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const auto back = r[k] < N(0.0f);
      inverse[k] = blend(back, N(-1.0f), N(1.0f)) / max(abs(r[k]), N(1e-18f));
      const N grow = blend(back, N(0.0f) - cull_radius, cull_radius);
      near[k] = (N(0.0f) - (o[k] + grow)) * inverse[k];
      far[k] = (grow - o[k]) * inverse[k];
      const N low = float(k * kSimdWidth << 8 * k), high = float((k + 3) * kSimdWidth << 8 * k);
      near_rows = near_rows + blend(back, high, low);
      far_rows = far_rows + blend(back, low, high);
    }
  }

  /// The offset of the row for axis k.
  static int row(const float& rows, int k) {
    return reinterpret_cast<const std::uint8_t*>(&rows)[std::endian::native == std::endian::little ? k : 3 - k];
  }

 private:
  static constexpr float kRows = 0x1p23f;  // the low bits of kRows + n are those of the integer n
};
using CullRay = CullRayOf<float>;

/// The projection along one ray with origin o, direction r, and u and v perpendicular to it.
inline ProjectedRay project(const Vec3& o, const Vec3& r, const Vec3& u, const Vec3& v, float cull_radius) {
  const auto copy = [](const Vec3& x, float (&to)[3]) { std::copy_n(x.data(), 3, to); };
  float a[3], b[3], c[3], d[3];
  copy(o, a);
  copy(r, b);
  copy(u, c);
  copy(v, d);
  return {a, b, c, d, cull_radius};
}

/// Prepare one ray for nodes; `projected`, for leaves, stays unset. Vectors are computed and stored as such: a vector
/// that is loaded after four stores of scalars has to wait for them.
[[gnu::always_inline]] inline void prepare_planes(CullRay& ray, const Vec3& o, const Vec3& r, float cull_radius,
                                                  float t_min) {
  const FloatX4 origin{o[0], o[1], o[2], 0.0f}, direction{r[0], r[1], r[2], 1.0f};
  const auto back = direction < 0.0f;
  const FloatX4 grow = back ? broadcast_x4(-cull_radius) : broadcast_x4(cull_radius);
  const FloatX4 inverse =
      (back ? broadcast_x4(-1.0f) : broadcast_x4(1.0f)) / max(back ? -direction : direction, broadcast_x4(1e-18f));
  const FloatX4 near = -(origin + grow) * inverse, far = (grow - origin) * inverse;
  std::memcpy(ray.inverse, &inverse, sizeof inverse);
  std::memcpy(ray.near, &near, sizeof near);
  std::memcpy(ray.far, &far, sizeof far);
  std::uint32_t near_rows = 0, far_rows = 0;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t low = std::uint32_t(k * kSimdWidth), high = low + 3 * kSimdWidth;
    near_rows |= (r[k] < 0.0f ? high : low) << 8 * k;
    far_rows |= (r[k] < 0.0f ? low : high) << 8 * k;
  }
  ray.near_rows = std::bit_cast<float>(near_rows);
  ray.far_rows = std::bit_cast<float>(far_rows);
  ray.t_min = t_min;
}

/// Prepare one ray for nodes and leaves.
inline CullRay cull_ray(const Vec3& o, const Vec3& r, const Vec3& u, const Vec3& v, float cull_radius, float t_min) {
  CullRay ray;
  prepare_planes(ray, o, r, cull_radius, t_min);
  ray.projected = project(o, r, u, v, cull_radius);
  return ray;
}

/// Prepare the packet that begins at lane `first`.
[[gnu::always_inline]] inline CullRayOf<FloatX16> cull_packet(const RayGroup& rays, int first) {
  const auto at = [first](const float* x) { return FloatX16::load(x + first); };
  const auto point = [&](const float (&x)[3][kGroupSize], FloatX16(&p)[3]) {
    for (int k = 0; k < 3; ++k) p[k] = at(x[k]);
  };
  FloatX16 o[3], r[3], u[3], v[3];
  point(rays.o, o);
  point(rays.r, r);
  point(rays.u, u);
  point(rays.v, v);
  return {o, r, u, v, at(rays.cull_radius), at(rays.t_min)};
}

/// Transpose a packet into 16 rays.
[[gnu::always_inline]] inline void transpose(const CullRayOf<FloatX16>& packet, CullRay* to) {
  constexpr int n = sizeof(packet) / sizeof(FloatX16);
  alignas(64) float columns[n][kSimdWidth];
  std::memcpy(columns, &packet, sizeof columns);
  transpose_columns<n>([&](int k) { return columns[k]; }, to);
}

/// Prepare the 16 rays from lane `first` on, one by one in `to`.
inline void cull_rays(const RayGroup& rays, int first, CullRay* to) { transpose(cull_packet(rays, first), to); }

/// A block's origin; lane 3 holds its scale, which callers ignore.
template <class Block>
FloatX4 origin_of(const Block& block) {
  FloatX4 origin;
  std::memcpy(&origin, &block, sizeof origin);
  return origin;
}

/// A mask of the first n boxes of a block that the ray may hit before `limit`, each grown by the culling radius. Sets
/// `enter` to where it enters each box: t in the frame.
template <class Block>
[[gnu::always_inline]] inline std::uint32_t cull_boxes(const CullRay& ray, const Block& block,
                                                       const std::uint8_t* planes, unsigned n, float limit,
                                                       FloatX16& enter) {
  using F = FloatX16;
  const FloatX4 inverse = load_x4(ray.inverse), origin = origin_of(block), step = inverse * broadcast_x4(block.scale);
  const FloatX4 to_near = fma(inverse, origin, load_x4(ray.near)), to_far = fma(inverse, origin, load_x4(ray.far));
  F near = ray.t_min, far = limit;
  const auto clip = [&](auto k) __attribute__((always_inline)) {
    const F a_step = F::broadcast<k>(step);
    near = max(fma(F::bytes(planes + CullRay::row(ray.near_rows, k)), a_step, F::broadcast<k>(to_near)), near);
    far = min(fma(F::bytes(planes + CullRay::row(ray.far_rows, k)), a_step, F::broadcast<k>(to_far)), far);
  };
  clip(std::integral_constant<int, 0>());
  clip(std::integral_constant<int, 1>());
  clip(std::integral_constant<int, 2>());
  enter = near;
  return (near <= far).bits() & ((1u << n) - 1);
}

/// A mask of the children whose boxes the ray may hit before `limit`.
[[gnu::always_inline]] inline std::uint32_t cull_node(const CullRay& ray, const WideNode& node, float limit,
                                                      FloatX16& enter) {
  return cull_boxes(ray, node, node.planes, node.n_children, limit, enter);
}

/// A mask of the pieces of a leaf that may come within the culling radius of the ray, or of its line. `offset` is that
/// of axes.
template <RayPrimitive P>
[[gnu::always_inline]] inline std::uint32_t cull_pieces(const CullRay& ray, const WideLeaf& leaf,
                                                        const LeafOffset& offset) {
  if constexpr (!AxisPrimitive<P>) {
    FloatX16 enter;
    if (!MixedPrimitive<P> || leaf.shape == LeafShape::boxes)
      return cull_boxes(ray, leaf, leaf.ends, leaf.n_refs, kInfinity, enter);
  }
  return cull_leaf(ray.projected, leaf, offset);
}

}  // namespace fastlines
