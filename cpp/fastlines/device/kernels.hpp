// The kernels: one thread a ray, or one group of threads (group.hpp). They are compiled for one kind of primitive,
// FASTLINES_PRIMITIVES.
//
// Numbers come as 64 bits, so that a launch passes pointers and numbers alike. Threads beyond the last ray do nothing.
#pragma once

#include "device_prim_list.hpp"
#include "device_ray_check.hpp"
#include "device_traversal.hpp"
#include "group_traversal.hpp"
#include "thread.hpp"

#if !defined(FASTLINES_PRIMITIVES)
#define FASTLINES_PRIMITIVES DeviceSegments
#endif

namespace fastlines {

/// The ray that the calling thread takes: its number, or n if there is none.
inline std::uint64_t ray_of_thread(const DeviceRays& rays) {
  const std::uint64_t number = thread_index() / kGroup;
  if (number >= rays.n || !runs_lanes()) return rays.n;
  return rays.order ? rays.order[number] : number;
}

/// Ray i of a query on P, as the caller gave it.
template <class P>
RayQuery query_of(const DeviceRays& rays, std::uint64_t i) {
  const float *const o = rays.origins + i * rays.origin_step, *const d = rays.directions + i * rays.direction_step;
  return {{o[0], o[1], o[2]},
          {d[0], d[1], d[2]},
          rays.t_min[i * rays.t_min_step],
          rays.t_max[i * rays.t_max_step],
          rays.radius[i * rays.radius_step],
          kHasSpread<P> ? rays.spread[i * rays.spread_step] : 0.0f};
}

/// Ray i of a query on P, prepared.
template <class P>
RayOf<P> prepared_ray(const DeviceRays& rays, std::uint64_t i, const Frame& frame) {
  return prepare_for<P>(query_of<P>(rays, i), frame);
}

/// Where a ray leaves a primitive, in units of the caller's ray.
template <class P>
float exit_of(const DeviceScene& scene, const RayOf<P>& ray, std::uint64_t prim) {
  return ray.t_ray(device_test<P>(ray, scene.items + prim * P::kFloats, scene.frame).exit());
}

/// Report the hits of a ray to the collector; to that of the group's leader, if a group takes the ray.
template <class P, RayCollector Collector>
void trace(const DeviceScene& scene, const RayOf<P>& ray, Collector& to) {
  if constexpr (kGroup > 1)
    trace_by_group<P>(scene, ray, to);
  else
    trace_by_thread<P>(scene, ray, to);
}

template <class P, class Where>
void first_hit_of_thread(const DeviceScene& scene, const DeviceRays& rays, Where where, const DeviceHits& to) {
  const std::uint64_t i = ray_of_thread(rays);
  if (i == rays.n) return;
  const RayOf<P> ray = prepared_ray<P>(rays, i, scene.frame);
  FirstHitOfRay<Where> first(ray, where);
  trace<P>(scene, ray, first);
  if (!is_leader()) return;
  Hit hit = first.hit();
  if (Where::kHasExit && first.found()) hit.t_out = exit_of<P>(scene, ray, first.prim);
  to.set(i, hit);
}

template <class P, At at>
void any_hit_of_thread(const DeviceScene& scene, const DeviceRays& rays, bool* to) {
  const std::uint64_t i = ray_of_thread(rays);
  if (i == rays.n) return;
  const RayOf<P> ray = prepared_ray<P>(rays, i, scene.frame);
  AnyHitOfRay<FixedAt<at>> found(ray);
  trace<P>(scene, ray, found);
  if (!is_leader()) return;
  to[i] = found.found;
}

template <class P, At at>
void count_hits_of_thread(const DeviceScene& scene, const DeviceRays& rays, std::uint64_t at_most, std::int64_t* to) {
  const std::uint64_t i = ray_of_thread(rays);
  if (i == rays.n) return;
  const RayOf<P> ray = prepared_ray<P>(rays, i, scene.frame);
  HitCountOfRay<FixedAt<at>> found(ray, at_most);
  trace<P>(scene, ray, found);
  if (!is_leader()) return;
  to[i] = std::int64_t(found.n);
}

template <class P, Keep keep, class Where>
void list_hits_of_thread(const DeviceScene& scene, const DeviceRays& rays, Where where, const DeviceLists& to) {
  const std::uint64_t i = ray_of_thread(rays);
  if (i == rays.n) return;
  const RayOf<P> ray = prepared_ray<P>(rays, i, scene.frame);
  const auto first = std::uint64_t(to.offsets[i]), room = std::uint64_t(to.offsets[i + 1]) - first;
  DeviceHits store = to.hits.from(first);
  store.t_out = nullptr;  // of those that are kept, in the end
  HitListOfRay<FixedList<Where, keep>, DeviceHits, P::kHasBoxes> list(ray, {where}, store, room);
  trace<P>(scene, ray, list);
  if (!is_leader()) return;
  list.finish();
  if (to.n_hits) to.n_hits[i] = std::int64_t(list.size());
  if constexpr (Where::kHasExit)
    for (std::uint64_t j = 0; j < list.size(); ++j)
      to.hits.t_out[first + j] = exit_of<P>(scene, ray, std::uint64_t(list[j].prim));
}

/// Count each primitive that a ray hits once, where it may be in several leaves. The lists of `offsets`, from a count
/// of all that rays find, have room in `prims`.
template <class P>
void count_prims_of_thread(const DeviceScene& scene, const DeviceRays& rays, At at, const std::int64_t* offsets,
                           std::uint32_t* prims, std::int64_t* to) {
  const std::uint64_t i = ray_of_thread(rays);
  if (i == rays.n) return;
  const RayOf<P> ray = prepared_ray<P>(rays, i, scene.frame);
  PrimListOfRay list(ray, at, prims + offsets[i]);
  trace<P>(scene, ray, list);
  if (!is_leader()) return;
  to[i] = std::int64_t(list.count());
}

/// The first hit of a ray, and the steps that it takes.
struct CountedFirstHit : FirstHitOfRay<FixedAt<At::closest>>, DeviceSteps {
  using FirstHitOfRay::FirstHitOfRay;
};

/// Write how many nodes, leaves and exact tests the search for each first hit takes, for benchmarks.
FASTLINES_KERNEL first_steps(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                             DeviceSteps* to) {
  const std::uint64_t i = ray_of_thread(*rays);
  if (i == rays->n) return;
  const auto ray = prepared_ray<FASTLINES_PRIMITIVES>(*rays, i, scene->frame);
  CountedFirstHit found(ray);
  trace<FASTLINES_PRIMITIVES>(*scene, ray, found);
  if (!is_leader()) return;
  to[i] = found;
}

/// Add the number of rays that are not valid to `n_invalid`; one thread a ray.
FASTLINES_KERNEL check_rays(const DeviceLimits* limits, const DeviceRays* rays, std::uint32_t* n_invalid) {
  const std::uint64_t i = thread_index();
  if (i < rays->n && !is_valid(query_of<FASTLINES_PRIMITIVES>(*rays, i), *limits)) add_one(n_invalid);
}

/// Numbers that one thread adds up.
inline constexpr std::uint64_t kScanRun = 256;

// The kernels of queries. Those on the surface take the number of their `At`: `At::surface` or `At::entry`.

FASTLINES_KERNEL first_closest(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                               const DeviceHits* to) {
  first_hit_of_thread<FASTLINES_PRIMITIVES>(*scene, *rays, FixedAt<At::closest>(), *to);
}
FASTLINES_KERNEL first_surface(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                               std::uint64_t at, const DeviceHits* to) {
  first_hit_of_thread<FASTLINES_PRIMITIVES>(*scene, *rays, SurfaceAt(At(at)), *to);
}
FASTLINES_KERNEL any_hit(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays, bool* to) {
  any_hit_of_thread<FASTLINES_PRIMITIVES, At::closest>(*scene, *rays, to);
}
FASTLINES_KERNEL any_entry(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays, bool* to) {
  any_hit_of_thread<FASTLINES_PRIMITIVES, At::entry>(*scene, *rays, to);
}
FASTLINES_KERNEL count_hits(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                            std::uint64_t at_most, std::int64_t* to) {
  count_hits_of_thread<FASTLINES_PRIMITIVES, At::closest>(*scene, *rays, at_most, to);
}
FASTLINES_KERNEL count_entries(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                               std::uint64_t at_most, std::int64_t* to) {
  count_hits_of_thread<FASTLINES_PRIMITIVES, At::entry>(*scene, *rays, at_most, to);
}

FASTLINES_KERNEL count_prims(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                             std::uint64_t at, const std::int64_t* offsets, std::uint32_t* prims, std::int64_t* to) {
  if constexpr (FASTLINES_PRIMITIVES::kHasBoxes)
    count_prims_of_thread<FASTLINES_PRIMITIVES>(*scene, *rays, At(at), offsets, prims, to);
}

/// All hits.
FASTLINES_KERNEL all_closest(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                             const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::all>(*scene, *rays, FixedAt<At::closest>(), *to);
}
FASTLINES_KERNEL all_surface(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                             std::uint64_t at, const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::all>(*scene, *rays, SurfaceAt(At(at)), *to);
}
/// The first hits by t, of which there is room for k or all.
FASTLINES_KERNEL next_closest(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                              const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::first>(*scene, *rays, FixedAt<At::closest>(), *to);
}
FASTLINES_KERNEL next_surface(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                              std::uint64_t at, const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::first>(*scene, *rays, SurfaceAt(At(at)), *to);
}
/// The hits that are nearest to the ray.
FASTLINES_KERNEL near_closest(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                              const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::nearest>(*scene, *rays, FixedAt<At::closest>(), *to);
}
FASTLINES_KERNEL near_surface(const DeviceScene* __restrict__ scene, const DeviceRays* __restrict__ rays,
                              std::uint64_t at, const DeviceLists* to) {
  list_hits_of_thread<FASTLINES_PRIMITIVES, Keep::nearest>(*scene, *rays, SurfaceAt(At(at)), *to);
}

/// Move each of n lists, of which n_hits are left, to a place for exactly as many hits; one thread a list.
FASTLINES_KERNEL move_lists(const DeviceLists* from, std::uint64_t n, const DeviceLists* to) {
  const std::uint64_t i = thread_index();
  if (i >= n) return;
  const DeviceHits &source = from->hits, &target = to->hits;
  std::int64_t j = from->offsets[i];
  for (std::int64_t k = to->offsets[i]; k < to->offsets[i + 1]; ++j, ++k) {
    Hit hit = source[j];
    if (target.t_out) hit.t_out = source.t_out[j];
    target.set(k, hit);
  }
}

/// Write the sum of each run of n numbers; one thread a run.
FASTLINES_KERNEL sum_runs(const std::int64_t* numbers, std::uint64_t n, std::int64_t* sums) {
  const std::uint64_t first = thread_index() * kScanRun;
  if (first >= n) return;
  std::int64_t sum = 0;
  for (std::uint64_t i = first; i < n && i < first + kScanRun; ++i) sum += numbers[i];
  sums[thread_index()] = sum;
}

/// Replace each of n numbers by the sum of all up to it. `sums` has those of whole runs up to each, or is null if there
/// is one run; one thread a run.
FASTLINES_KERNEL scan_runs(std::int64_t* numbers, std::uint64_t n, const std::int64_t* sums) {
  const std::uint64_t run = thread_index(), first = run * kScanRun;
  if (first >= n) return;
  std::int64_t sum = run > 0 ? sums[run - 1] : 0;
  for (std::uint64_t i = first; i < n && i < first + kScanRun; ++i) numbers[i] = sum += numbers[i];
}

}  // namespace fastlines
