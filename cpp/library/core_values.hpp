// Values of the interface as those of the core, and back.
#pragma once

#include "fastlines/api/tree.hpp"
#include "fastlines/kernels/run/kernel.hpp"
#include "fastlines/query/ray_collectors.hpp"

namespace fl::detail {

inline fastlines::Vec3 core_vector(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 vector_of(const fastlines::Vec3& v) { return {v[0], v[1], v[2]}; }
inline fastlines::At core_at(At at) { return fastlines::At(int(at)); }
inline fastlines::Keep core_keep(Rank rank) {
  return rank == Rank::distance ? fastlines::Keep::nearest : fastlines::Keep::first;
}
inline fastlines::Kernel core_kernel(QueryOptions::Kernel kernel) {
  using enum fastlines::Kernel;
  constexpr fastlines::Kernel kernels[] = {automatic, single, wave, bundle};
  return kernels[int(kernel)];
}
inline Hit hit_of(const fastlines::Hit& hit) { return {hit.t, hit.prim, hit.u, hit.distance, hit.t_out}; }

}  // namespace fl::detail
