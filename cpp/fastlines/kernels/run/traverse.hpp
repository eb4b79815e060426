// Traverses a wide layout with one ray, on the calling thread: for the queries of programs.
//
//     const auto ray = prepare_for<P>(query, tree.frame);
//     std::size_t n = 0;
//     traverse(tree, ray, [&](const ClosestApproach<float>& hit, const Reference& piece, float& limit) {
//       n += owns(piece.s0, piece.s1, hit.s) && is_wanted(piece.prim);
//     });
//
// counts the wanted primitives that a ray hits.
#pragma once

#include <concepts>
#include <memory>

#include "../../memory/thread_scratch.hpp"
#include "../traverse/single_ray.hpp"

namespace fastlines {

/// Report the hits of a ray to the collector, nearest node first. The ray is prepared for the tree's frame
/// (`prepare_for`), and valid (rays/ray_check.hpp). A `checkpoint` is passed on the way, if there is one.
template <RayPrimitive P, RayCollector C>
void traverse(const WideBvhView<P>& tree, const RayOf<P>& ray, C& to, Checkpoint* checkpoint = nullptr) {
  const float cull_radius = ray.radius + ray.eps;
  CullRay cull;
  prepare_planes(cull, ray.o, ray.r, cull_radius, ray.t_min);
  bool is_projected = false;
  // A thread keeps its stack from call to call. A traversal within another one's `add` gets a stack of its own.
  auto& spare = thread_scratch<std::unique_ptr<SingleRay<P>>>();
  std::unique_ptr<SingleRay<P>> single = std::move(spare);
  if (!single) single = std::make_unique<SingleRay<P>>();
  single->checkpoint = checkpoint;
  single->search(tree, ray, cull, to, [&] {
    if (!is_projected) cull.projected = project(ray.o, ray.r, ray.u, ray.v, cull_radius);
    is_projected = true;
  });
  spare = std::move(single);
}

/// The collector of a function.
template <class Visit>
struct VisitHits : ChosenAt {
  static constexpr bool kShrinksLimit = true, kDropsFarther = false;
  float limit;
  Visit& visit;

  void add(const ClosestApproach<float>& approach, const Reference& ref) {
    if (approach.t <= limit) visit(approach, ref, limit);
  }
};

/// Call visit(hit, piece, limit) for each hit of a ray, nearest node first. `hit` is in the frame of the tree:
/// `ray.t_ray(hit.t)` and `ray.distance(hit.dist2)` are in units of the caller's ray and of the scene. `piece` is the
/// part of a primitive that led to the hit.
///
/// A line that is in several leaves is reported for each, and one of its pieces owns the hit: `owns(piece.s0, piece.s1,
/// hit.s)`. Only an `AxisPrimitive` has such pieces; any other may be reported several times.
///
/// The function may lower `limit`, the t in the frame beyond which no hit is needed. With `kNoMoreHits` the traversal
/// ends.
template <RayPrimitive P, class Visit>
  requires std::invocable<Visit&, const ClosestApproach<float>&, const Reference&, float&>
void traverse(const WideBvhView<P>& tree, const RayOf<P>& ray, Visit&& visit, At at = At::closest) {
  VisitHits<std::remove_reference_t<Visit>> collector{{at}, ray.limit, visit};
  traverse(tree, ray, collector);
}

}  // namespace fastlines
