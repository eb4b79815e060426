// What culling needs of a ray, and the test of a ray against the 16 boxes of a node; that against the 16 pieces of a
// leaf is in cull_leaf.hpp.
//
// Both may differ in rounding between instruction sets; both err on the side of a visit.
#pragma once

#include <bit>

#include "../rays/ray_group.hpp"
#include "leaf_cull.hpp"

namespace fastlines {

/// What culling needs of a ray (or of a bundle's centre), or of sixteen: its line, and how near counts. N is float or
/// FloatX16. Numbers stand in fours: so those of sixteen rays are turned into sixteen of these.
template <class N>
struct alignas(64) CullRayOf {
  N inverse[4], near[4], far[4];  // box planes: q·(scale·inverse) + (org·inverse + near); the fourth are nothing
  N near_rows, far_rows;          // where a node's bytes of the planes begin, a byte each of x, y and z
  N t_min, unused;
  ProjectedRayOf<N> across;  // what leaves see of it

  CullRayOf() = default;
  CullRayOf(const N (&o)[3], const N (&r)[3], const N (&u)[3], const N (&v)[3], N reach, N t_min_)
      : near_rows(kRows), far_rows(kRows), t_min(t_min_), unused(0.0f), across(o, r, u, v, reach) {
    inverse[3] = near[3] = far[3] = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const auto back = r[k] < N(0.0f);
      inverse[k] = blend(back, N(-1.0f), N(1.0f)) / max(abs(r[k]), N(1e-18f));
      const N grow = blend(back, N(0.0f) - reach, reach);
      near[k] = (N(0.0f) - (o[k] + grow)) * inverse[k];
      far[k] = (grow - o[k]) * inverse[k];
      const N low = float(k * kSimdWidth << 8 * k), high = float((k + 3) * kSimdWidth << 8 * k);
      near_rows = near_rows + blend(back, high, low);
      far_rows = far_rows + blend(back, low, high);
    }
  }

  static int row(const float& rows, int k) {
    return reinterpret_cast<const std::uint8_t*>(&rows)[std::endian::native == std::endian::little ? k : 3 - k];
  }

 private:
  static constexpr float kRows = 0x1p23f;  // the bits of a sum with it end in those of a whole number
};
using CullRay = CullRayOf<float>;

inline CullRay cull_ray(const Vec3& o, const Vec3& r, const Vec3& u, const Vec3& v, float reach, float t_min) {
  const auto all = [](const Vec3& x, float (&to)[3]) { std::copy_n(x.data(), 3, to); };
  float a[3], b[3], c[3], d[3];
  all(o, a);
  all(r, b);
  all(u, c);
  all(v, d);
  return {a, b, c, d, reach, t_min};
}

/// Of sixteen rays at once, in lanes from `first` on.
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
  return {o, r, u, v, at(rays.reach), at(rays.t_min)};
}

/// Of each of them.
[[gnu::always_inline]] inline void transpose(const CullRayOf<FloatX16>& sixteen, CullRay* to) {
  constexpr int n = sizeof(sixteen) / sizeof(FloatX16);
  alignas(64) float columns[n][kSimdWidth];
  std::memcpy(columns, &sixteen, sizeof columns);
  transpose_columns<n>([&](int k) { return columns[k]; }, to);
}

inline void cull_rays(const RayGroup& rays, int first, CullRay* to) { transpose(cull_packet(rays, first), to); }

/// A node's origin, and a lane that means nothing.
inline FloatX4 origin_of(const WideNode& node) {
  FloatX4 origin;
  std::memcpy(&origin, &node, sizeof origin);
  return origin;
}

/// The children whose boxes the ray may meet before `limit`, and where it enters them.
[[gnu::always_inline]] inline std::uint32_t cull_node(const CullRay& ray, const WideNode& node, float limit,
                                                      FloatX16& enter) {
  using F = FloatX16;
  const FloatX4 inverse = four(ray.inverse), origin = origin_of(node), step = inverse * four(node.scale);
  const FloatX4 to_near = fma(inverse, origin, four(ray.near)), to_far = fma(inverse, origin, four(ray.far));
  F near = ray.t_min, far = limit;
  const auto cut = [&](auto k) __attribute__((always_inline)) {
    const F a_step = F::broadcast<k>(step);
    near = max(fma(F::bytes(node.planes + CullRay::row(ray.near_rows, k)), a_step, F::broadcast<k>(to_near)), near);
    far = min(fma(F::bytes(node.planes + CullRay::row(ray.far_rows, k)), a_step, F::broadcast<k>(to_far)), far);
  };
  cut(std::integral_constant<int, 0>());
  cut(std::integral_constant<int, 1>());
  cut(std::integral_constant<int, 2>());
  enter = near;
  return (near <= far).bits() & ((1u << node.n_children) - 1);
}

}  // namespace fastlines
