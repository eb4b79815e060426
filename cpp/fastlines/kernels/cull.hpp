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
  float inverse[3], near[3], far[3];  // box planes: q·(scale·inverse) + (org·inverse − near)
  int near_row[3], far_row[3];        // where a node's bytes of the near and the far planes begin
  float t_min;
  Across across;  // what leaves see of it

  CullRay() = default;
  explicit CullRay(const Ray& ray) : CullRay(ray.o, ray.r, ray.u, ray.v, ray.radius + ray.eps, ray.t_min) {}
  CullRay(const Vec3& origin, const Vec3& r, const Vec3& u, const Vec3& v, float reach, float t_min_)
      : t_min(t_min_), across(origin, r, u, v, reach) {
    for (int k = 0; k < 3; ++k) {
      const float component = std::copysign(std::max(std::abs(r[k]), 1e-18f), r[k]);
      inverse[k] = 1.0f / component;
      const bool backwards = component < 0.0f;
      const float grow = std::copysign(reach, component);
      near_row[k] = (backwards ? k + 3 : k) * kWidth;
      far_row[k] = (backwards ? k : k + 3) * kWidth;
      near[k] = (origin[k] + grow) * inverse[k];
      far[k] = (origin[k] - grow) * inverse[k];
    }
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
