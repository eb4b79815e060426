// The queries on a wide layout of one kind of primitive. The kernels take long to compile, so each kind has a source
// file of its own, queries_*.cpp. A kind without one is compiled where it is used.
#pragma once

#include <optional>

#include "fastlines/kernels/run/run_batch.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/primitives/spread_cones.hpp"

namespace fastlines {

/// A batch of rays on a layout. With a spread, `at` is always `At::closest`.
template <RayPrimitive P>
struct LayoutQueries {
  const WideBvhView<P>& tree;
  const RayBatch& rays;
  Kernel kernel;
  unsigned n_threads;
  Progress& progress;

  void find_first(At at, const HitColumns& to) const;
  void find_any(bool* to) const;
  void count(std::int64_t* to) const;
  /// List all hits of each ray, or its first k by t if k is given, or the k nearest to it with `by_distance`.
  void list(At at, std::optional<std::size_t> k, bool by_distance, HitAssembler& to) const;

 private:
  /// Calls run_at<at>().
  template <class RunAt>
  static void dispatch(At at, const RunAt& run_at) {
    if constexpr (!kHasSpread<P>)
      if (at == At::surface) return run_at.template operator()<At::surface>();
    run_at.template operator()<At::closest>();
  }
};

template <RayPrimitive P>
void LayoutQueries<P>::find_first(At at, const HitColumns& to) const {
  const auto run_at = [&]<At which>() {
    run_batch(tree, rays, kernel, FirstHitQuery<P, which>{tree, to}, n_threads, progress);
  };
  dispatch(at, run_at);
}

template <RayPrimitive P>
void LayoutQueries<P>::find_any(bool* to) const {
  run_batch(tree, rays, kernel, AnyHitQuery{to}, n_threads, progress);
}

template <RayPrimitive P>
void LayoutQueries<P>::count(std::int64_t* to) const {
  run_batch(tree, rays, kernel, CountHitsQuery{to}, n_threads, progress);
}

template <RayPrimitive P>
void LayoutQueries<P>::list(At at, std::optional<std::size_t> k, bool by_distance, HitAssembler& to) const {
  if (!k || by_distance) return run_lists(tree, rays, kernel, AllHitsQuery<P>(tree, at, k), n_threads, progress, to);
  const auto run_at = [&]<At which>() {
    run_lists(tree, rays, kernel, KNearestQuery<P, which>(tree, *k), n_threads, progress, to);
  };
  dispatch(at, run_at);
}

/// Whether a module has the queries on P. One that counts steps has those on segments alone, which compiles sooner.
#ifdef FASTLINES_SEGMENTS_ONLY
template <RayPrimitive P>
inline constexpr bool kHasQueries = std::same_as<P, Segments>;
#else
template <RayPrimitive P>
inline constexpr bool kHasQueries = true;
#endif

extern template struct LayoutQueries<Segments>;
extern template struct LayoutQueries<RoundCones>;
extern template struct LayoutQueries<SpreadCones>;
extern template struct LayoutQueries<Shapes>;

}  // namespace fastlines
