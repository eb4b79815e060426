// Tests a ray and a primitive exactly: what every search of one ray at a time does with the primitives it visits.
#pragma once

#include "../primitives/ray_primitive.hpp"
#include "../rays/spread_ray.hpp"
#include "ray_collectors.hpp"

namespace fastlines {

/// The exact test of a ray and a primitive. It must not outlive the ray.
template <RayPrimitive P>
[[gnu::always_inline]] inline auto exact_test(const P& prims, const RayOf<P>& ray, const Frame& frame,
                                              std::uint32_t prim) {
  return P::template test<float>(ray, fields_of<P>(prims.item(prim), frame));
}

/// Test a ray and a primitive, and report a hit to the collector. Returns whether the ray needs no more hits.
template <RayPrimitive P, RayCollector C>
bool test_primitive(const P& prims, const RayOf<P>& ray, const Frame& frame, const Reference& ref, C& to) {
  const auto test = exact_test(prims, ray, frame, ref.prim);
  if (!test.closest.hit) return false;
  const auto approach = approach_at(to.at, test);
  if (approach.hit) to.add(approach, ref);
  return to.limit == kNoMoreHits;
}

/// Where a ray leaves a primitive that it hits, in units of the caller's ray.
template <RayPrimitive P>
float exit_of(const P& prims, const RayOf<P>& ray, const Frame& frame, std::uint32_t prim) {
  return ray.t_ray(exact_test(prims, ray, frame, prim).exit());
}

}  // namespace fastlines
