// What the queries on a layout run. Each queries_*.cpp includes this for one kind of primitive.
#pragma once

#include "fastlines/kernels/run/run_batch.hpp"
#include "layout_queries.hpp"

namespace fastlines {

/// Calls run_at(where).
template <RayPrimitive P, class RunAt>
void dispatch(At at, const RunAt& run_at) {
  if constexpr (!kHasSpread<P>)
    if (at != At::closest) return run_at(SurfaceAt(at));
  run_at(FixedAt<At::closest>());
}

template <RayPrimitive P>
void LayoutQueries<P>::find_first(At at, const HitColumns& to) const {
  const auto run_at = [&]<class Where>(Where where) {
    run_batch(tree, rays, kernel, FirstHitQuery<P, Where>{tree, to, where}, n_threads, progress);
  };
  dispatch<P>(at, run_at);
}

template <RayPrimitive P>
void LayoutQueries<P>::find_first_crossing(At at, PieceOwners owners, const HitColumns& to) const {
  if constexpr (!kHasSpread<P>) {
    const FirstHitQuery<P, SurfaceAt> query{tree, to, at, FirstCrossings<P>(tree, rays, owners, at)};
    run_batch(tree, rays, kernel, query, n_threads, progress);
  }
}

template <RayPrimitive P>
void LayoutQueries<P>::find_any(At at, bool* to) const {
  if constexpr (!kHasSpread<P>)
    if (at == At::entry) return run_batch(tree, rays, kernel, AnyHitQuery<FixedAt<At::entry>>{to}, n_threads, progress);
  run_batch(tree, rays, kernel, AnyHitQuery<>{to}, n_threads, progress);
}

template <RayPrimitive P>
void LayoutQueries<P>::count(At at, std::int64_t* to) const {
  if constexpr (!kHasSpread<P>)
    if (at == At::entry) return run_batch(tree, rays, kernel, CountEntriesQuery{to}, n_threads, progress);
  run_batch(tree, rays, kernel, CountHitsQuery{to}, n_threads, progress);
}

template <RayPrimitive P>
void LayoutQueries<P>::list(At at, std::optional<std::size_t> k, bool by_distance, HitAssembler& to) const {
  if (!k || by_distance) return run_lists(tree, rays, kernel, AllHitsQuery<P>(tree, at, k), n_threads, progress, to);
  const auto run_at = [&]<class Where>(Where where) {
    run_lists(tree, rays, kernel, KNearestQuery<P, Where>(tree, *k, where), n_threads, progress, to);
  };
  dispatch<P>(at, run_at);
}

template <RayPrimitive P>
void LayoutQueries<P>::gather(const GatherRule& rule, const GatherSums& to) const
  requires AxisPrimitive<P>
{
  run_batch(tree, rays, kernel, GatherQuery<P>(tree, rays, rule, to), n_threads, progress);
}

}  // namespace fastlines
