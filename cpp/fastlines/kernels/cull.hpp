// What culling needs of a ray, and the test of a ray against the 16 boxes of a node; that against the 16 pieces of a
// leaf is in cull_leaf.hpp.
//
// Both may differ in rounding between instruction sets; both err on the side of a visit.
#pragma once

#include <bit>

#include "cull_leaf.hpp"

namespace fastlines {

/// What culling needs of a ray (or of a bundle's centre): its line, and how near counts.
struct CullRay {
  // In three lanes, of x, y and z.
  Float4 inverse, near, far;  // box planes: q·(scale·inverse) + (org·inverse − near)
  Int4 near_row, far_row;     // where a node's bytes of the near and the far planes begin
  float t_min;
  Across across;  // what leaves see of it

  CullRay() = default;
  explicit CullRay(const Ray& ray) : CullRay(ray.o, ray.r, ray.u, ray.v, ray.radius + ray.eps, ray.t_min) {}
  CullRay(const Vec3& origin, const Vec3& r, const Vec3& u, const Vec3& v, float reach, float t_min_)
      : t_min(t_min_), across(origin, r, u, v, reach) {
    const Float4 o{origin[0], origin[1], origin[2]}, along{r[0], r[1], r[2]};
    const Int4 sign = Int4(along) & std::numeric_limits<std::int32_t>::min();
    const auto signed_as = [=](Float4 size) { return Float4(Int4(size) | sign); };
    inverse = four(1.0f) / signed_as(max(Float4(Int4(along) ^ sign), four(1e-18f)));
    const Float4 grow = signed_as(four(reach));
    near = (o + grow) * inverse;
    far = (o - grow) * inverse;
    const Int4 swapped = (sign >> 31) & 3;
    near_row = (Int4{0, 1, 2} + swapped) * kWidth;
    far_row = (Int4{3, 4, 5} - swapped) * kWidth;
  }
};

/// The children whose boxes the ray may meet before `limit`, and where it enters them.
[[gnu::always_inline]] inline std::uint32_t cull_node(const CullRay& ray, const WideNode& node, float limit,
                                                      Float16& enter) {
  using F = Float16;
  F near = ray.t_min, far = limit;
  for (int k = 0; k < 3; ++k) {
    const F step = node.scale * ray.inverse[k];
    const float base = node.org[k] * ray.inverse[k];
    near = max(fma(F::bytes(node.planes + ray.near_row[k]), step, F(base - ray.near[k])), near);
    far = min(fma(F::bytes(node.planes + ray.far_row[k]), step, F(base - ray.far[k])), far);
  }
  enter = near;
  return (near <= far).bits() & ((1u << node.n_children) - 1);
}

}  // namespace fastlines
