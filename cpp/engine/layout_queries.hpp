// The queries on a wide layout of one kind of primitive. The kernels take long to compile, so each kind has a source
// file of its own, queries_*.cpp, and no other file is compiled again after a change of a kernel.
#pragma once

#include <optional>

#include "fastlines/kernels/run/kernel.hpp"
#include "fastlines/layout/wide_bvh.hpp"
#include "fastlines/parallel/progress.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/primitives/spread_cones.hpp"
#include "fastlines/query/crossings.hpp"
#include "fastlines/query/gather/hit_summer.hpp"
#include "fastlines/query/hit_assembler.hpp"
#include "fastlines/rays/ray_batch.hpp"

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
  /// Find the first crossing of each ray with a primitive in pieces, where `at` is on the surface: the piece that
  /// begins it, and the distance and t_out of the whole.
  void find_first_crossing(At at, PieceOwners owners, const HitColumns& to) const;
  void find_any(At at, bool* to) const;
  void count(At at, std::int64_t* to) const;
  /// List all hits of each ray, or its first k by t if k is given, or the k nearest to it with `by_distance`.
  void list(At at, std::optional<std::size_t> k, bool by_distance, HitAssembler& to) const;
  /// Sum over all hits of each ray.
  void gather(const GatherRule& rule, const GatherSums& to) const
    requires AxisPrimitive<P>;
};

/// Whether a module has the queries on P. One that counts steps has those on segments alone, which compiles sooner.
#ifdef FASTLINES_SEGMENTS_ONLY
template <RayPrimitive P>
inline constexpr bool kHasQueries = std::same_as<P, Segments>;
#else
template <RayPrimitive P>
inline constexpr bool kHasQueries = true;
#endif

}  // namespace fastlines
