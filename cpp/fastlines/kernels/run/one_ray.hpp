// Answers queries for one ray on the calling thread, for programs that ask for one ray at a time. A batch of one ray
// would prepare 16 lanes and allocate a dispatcher.
//
// `AnyHit` is `Hit`, or a struct of the same members in the same order.
#pragma once

#include <vector>

#include "../../query/hit_vector.hpp"
#include "../collect/exit_points.hpp"
#include "traverse.hpp"

namespace fastlines {

/// A ray that is prepared for a tree. Preconditions: the ray is valid (rays/ray_check.hpp), and has no spread.
template <AxisPrimitive P>
class OneRay {
 public:
  OneRay(const WideBvhView<P>& tree, const RayQuery& query) : tree_(tree), ray_(prepare(query, tree.frame)) {}

  Hit first_hit(At at) const {
    FirstHitOfRay<ChosenAt> first(ray_, {at});
    traverse(tree_, ray_, first);
    Hit hit = first.hit();
    if (has_exit(at) && first.found()) store_exits(std::span(&hit, 1));
    return hit;
  }

  bool any_hit(At at) const {
    if (at == At::entry) return traversed(AnyHitOfRay<FixedAt<At::entry>>(ray_)).found;
    return traversed(AnyHitOfRay(ray_)).found;
  }

  std::size_t count_hits(At at) const {
    if (at == At::entry) return traversed(HitCountOfRay<FixedAt<At::entry>>(ray_)).n;
    return traversed(HitCountOfRay(ray_)).n;
  }

  /// Replace `to` by all hits, in their order.
  template <class AnyHit>
  void all_hits(At at, std::vector<AnyHit>& to) const {
    list_hits(at, Keep::all, ~0ull, to);
  }

  /// Replace `to` by the first k hits, or the k nearest to the ray, in their order.
  template <class AnyHit>
  void next_hits(std::size_t k, At at, Keep keep, std::vector<AnyHit>& to) const {
    list_hits(at, keep, k, to);
  }

 private:
  /// A collector after the traversal.
  template <class Collector>
  Collector traversed(Collector collector) const {
    traverse(tree_, ray_, collector);
    return collector;
  }

  template <class AnyHit>
  void list_hits(At at, Keep keep, std::uint64_t k, std::vector<AnyHit>& to) const {
    HitVectorOfRay<AnyHit> list(ray_, at, keep, to, k);
    traverse(tree_, ray_, list);
    list.finish();
    if (has_exit(at)) store_exits(std::span(to));
  }

  /// Set where the ray leaves the primitives that it hits.
  template <class AnyHit>
  void store_exits(std::span<AnyHit> hits) const {
    for (std::size_t first = 0; first < hits.size(); first += kSimdWidth) {
      const auto n = std::uint32_t(std::min<std::size_t>(hits.size() - first, kSimdWidth));
      std::uint32_t prims[kSimdWidth];
      float t_out[kSimdWidth];
      for (std::uint32_t i = 0; i < n; ++i) prims[i] = std::uint32_t(hits[first + i].prim);
      fastlines::store_exits(tree_, ray_, [this](float t) { return ray_.t_ray(t); }, prims, n, t_out);
      for (std::uint32_t i = 0; i < n; ++i) hits[first + i].t_out = t_out[i];
    }
  }

  const WideBvhView<P>& tree_;
  const Ray ray_;
};

}  // namespace fastlines
