// The two culling tests: a ray against the 16 boxes of a node, and against the 16 pieces of a leaf.
//
// Both may differ in rounding between instruction sets; both err on the side of a visit.
#pragma once

#include <bit>

#include "../layout/wide.hpp"
#include "../query/ray.hpp"

namespace fastlines {

/// What culling needs of a ray (or of a bundle's centre): its line, and how near counts.
struct CullRay {
  float inverse[3], near[3], far[3];  // box planes: q·(scale·inverse) + (org·inverse − near)
  int near_row[3], far_row[3];        // where a node's bytes of the near and the far planes begin
  float t_min;
  float o[3], u[3], v[3], reach;  // reach: radius and rounding
  float away_u, away_v;           // −o·u, −o·v

  CullRay() = default;
  explicit CullRay(const Ray& ray) : CullRay(ray.o, ray.r, ray.u, ray.v, ray.radius + ray.eps, ray.t_min) {}
  CullRay(const Vec3& origin, const Vec3& r, const Vec3& u_, const Vec3& v_, float reach_, float t_min_)
      : t_min(t_min_), reach(reach_) {
    for (int k = 0; k < 3; ++k) {
      const float component = std::copysign(std::max(std::abs(r[k]), 1e-18f), r[k]);
      inverse[k] = 1.0f / component;
      const bool backwards = component < 0.0f;
      const float grow = std::copysign(reach, component);
      near_row[k] = (backwards ? k + 3 : k) * kWidth;
      far_row[k] = (backwards ? k : k + 3) * kWidth;
      near[k] = (origin[k] + grow) * inverse[k];
      far[k] = (origin[k] - grow) * inverse[k];
      o[k] = origin[k];
      u[k] = u_[k];
      v[k] = v_[k];
    }
    away_u = -dot(origin, u_);
    away_v = -dot(origin, v_);
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

/// The pieces that may come within reach of the ray's line. In quanta: rounding an end moves it by at most √3/2, and
/// with it every point of the piece by no more; the rest of 0.89 is for the rounding of the arithmetic. Most leaves
/// fail at the line already, but too many do not: a branch there costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const CullRay& ray, const WideLeaf& leaf) {
  using F = Float16;
  // Where the leaf lies, seen along the ray, and how near counts there.
  const auto beside = [&](const float (&axis)[3], float away) {
    return fma(leaf.org[2], axis[2], fma(leaf.org[1], axis[1], fma(leaf.org[0], axis[0], away))) * leaf.per_scale;
  };
  const F bu = beside(ray.u, ray.away_u), bv = beside(ray.v, ray.away_v);
  const float near = ray.reach * leaf.per_scale + 0.89f;
  const F near2 = near * near;
  const F ax = F::bytes(leaf.a[0]), ay = F::bytes(leaf.a[1]), az = F::bytes(leaf.a[2]);
  const F cx = F::bytes(leaf.c[0]), cy = F::bytes(leaf.c[1]), cz = F::bytes(leaf.c[2]);
  const F ux = ray.u[0], uy = ray.u[1], uz = ray.u[2], vx = ray.v[0], vy = ray.v[1], vz = ray.v[2];
  const F au = fma(az, uz, fma(ay, uy, fma(ax, ux, bu))), av = fma(az, vz, fma(ay, vy, fma(ax, vx, bv)));
  const F cu = fma(cz, uz, fma(cy, uy, fma(cx, ux, bu))), cv = fma(cz, vz, fma(cy, vy, fma(cx, vx, bv)));
  const F wu = cu - au, wv = cv - av;
  const F cross = au * wv - av * wu;
  // Never 0 · infinity, which would be no number.
  const auto line = cross * cross <= fma(fma(wu, wu, fma(wv, wv, F(1e-30f))), near2, F(1e-3f));
  const auto inside = (fma(au, wu, av * wv) <= F(0.0f)) & (F(0.0f) <= fma(cu, wu, cv * wv));
  const auto ends = min(fma(au, au, av * av), fma(cu, cu, cv * cv)) <= near2;
  return (line & (inside | ends)).bits() & ((1u << leaf.n_refs) - 1);
}

}  // namespace fastlines
