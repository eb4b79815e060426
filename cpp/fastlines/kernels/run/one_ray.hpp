// Answers queries for one ray on the calling thread, for programs that ask for one ray at a time.
//
// A batch of one ray would prepare 16 lanes and allocate a dispatcher. Here lane 0 of a group holds the ray, the other
// lanes stay unset, and each thread keeps its stack from call to call.
//
// `AnyHit` is `Hit`, or a struct of the same members in the same order.
#pragma once

#include <algorithm>
#include <vector>

#include "../../memory/thread_scratch.hpp"
#include "../collect/any_hit.hpp"
#include "../collect/first_hit.hpp"
#include "../collect/k_nearest.hpp"
#include "../traverse/single_ray.hpp"

namespace fastlines {

/// Counts the hits of one ray.
struct OneRayCounter : FixedAt<At::closest> {
  static constexpr QueryTraits kTraits{.needs_position = false};
  float limit[1];
  std::size_t n_hits = 0;

  void add_hit(const RayGroup&, int, const ClosestApproach<float>& approach, const Reference& ref) {
    n_hits += owns(ref.s0, ref.s1, approach.s);
  }
};

/// Appends the hits of one ray to a vector, in no order.
template <class AnyHit>
struct OneRayLister : ChosenAt {
  static constexpr QueryTraits kTraits{};
  float limit[1];
  std::vector<AnyHit>& hits;

  void add_hit(const RayGroup& rays, int i, const ClosestApproach<float>& approach, const Reference& ref) {
    if (!owns(ref.s0, ref.s1, approach.s)) return;
    hits.push_back(
        {rays.t_ray(i, approach.t), ref.prim, approach.s, float(std::sqrt(approach.dist2) * rays.inv_scale)});
  }
};

/// A ray that is prepared for a tree. Preconditions: the ray is valid (rays/ray_check.hpp), and has no spread.
template <AxisPrimitive P>
class OneRay {
 public:
  OneRay(const WideBvhView<P>& tree, const RayQuery& query) : tree_(tree), ray_(prepare(query, tree.frame)) {
    rays_.n = 1;
    rays_.inv_scale = ray_.inv_scale;
    rays_.store(0, ray_);
  }

  Hit first_hit(At at) const {
    FirstHitCollector<ChosenAt> found;
    found.at = at;
    found.begin(rays_, 0, 1);
    search(found);
    const auto prim = std::bit_cast<std::uint32_t>(found.prim[0]);
    if (prim == kNoPrim) return {};
    Hit hit{rays_.t_ray(0, found.t[0]), prim, found.s[0], float(std::sqrt(found.dist2[0]) * rays_.inv_scale)};
    if (at == At::surface) store_exits(std::span(&hit, 1));
    return hit;
  }

  bool any_hit() const {
    AnyHitCollector found;
    found.begin(rays_, 0, 1);
    search(found);
    return found.found[0];
  }

  std::size_t count_hits() const {
    OneRayCounter found{{}, {rays_.t_max[0]}};
    search(found);
    return found.n_hits;
  }

  /// Replace `to` by all hits, in their order.
  template <class AnyHit>
  void all_hits(At at, std::vector<AnyHit>& to) const {
    to.clear();
    OneRayLister<AnyHit> found{{at}, {rays_.t_max[0]}, to};
    search(found);
    finish(at, to);
  }

  /// Replace `to` by the first k hits, in their order.
  template <class AnyHit>
  void next_hits(std::size_t k, At at, std::vector<AnyHit>& to) const {
    struct Nearest {
      KNearestCollector<ChosenAt> collector{0};
    };
    KNearestCollector<ChosenAt>& found = thread_scratch<Nearest>().collector;
    found.k = k;
    found.at = at;
    found.begin(rays_, 0, 1);
    search(found);
    to.clear();
    const KNearest& hits = found.hits[0];
    for (std::uint32_t j = 0; j < hits.n; ++j)
      to.push_back({hits.t_ray[j], hits.prim[j], hits.s[j], float(std::sqrt(hits.dist2[j]) * rays_.inv_scale)});
    finish(at, to);
  }

 private:
  template <class Collector>
  void search(Collector& to) const {
    const float reach = ray_.radius + ray_.eps;
    CullRay cull;
    prepare_planes(cull, ray_.o, ray_.r, reach, ray_.t_min);
    bool is_projected = false;
    thread_scratch<SingleRay<P>>().search(tree_, rays_, 0, cull, to, [&] {
      if (!is_projected) cull.projected = project(ray_.o, ray_.r, ray_.u, ray_.v, reach);
      is_projected = true;
    });
  }

  /// Sort hits, and set where the ray leaves their primitives.
  template <class AnyHit>
  void finish(At at, std::vector<AnyHit>& hits) const {
    std::sort(hits.begin(), hits.end(),
              [](const AnyHit& a, const AnyHit& b) { return precedes(a.t, a.prim, b.t, b.prim); });
    if (at == At::surface) store_exits(std::span(hits));
  }

  template <class AnyHit>
  void store_exits(std::span<AnyHit> hits) const {
    for (std::size_t first = 0; first < hits.size(); first += kSimdWidth) {
      const auto n = std::uint32_t(std::min<std::size_t>(hits.size() - first, kSimdWidth));
      std::uint32_t prims[kSimdWidth];
      float t_out[kSimdWidth];
      for (std::uint32_t i = 0; i < n; ++i) prims[i] = std::uint32_t(hits[first + i].prim);
      store_exits_of_ray(tree_, rays_, 0, prims, n, t_out);
      for (std::uint32_t i = 0; i < n; ++i) hits[first + i].t_out = t_out[i];
    }
  }

  const WideBvhView<P>& tree_;
  const Ray ray_;
  RayGroup rays_;  // the ray in lane 0, where the kernel reads it
};

}  // namespace fastlines
