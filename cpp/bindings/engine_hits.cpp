// Queries with one answer for each ray: its first hit, whether there is any, how many there are.
#include <nanobind/nanobind.h>

#include "engine.hpp"
#include "fastlines/rays/ray_check.hpp"
#include "query.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

HitTuple first(const LayoutView& layout, RayArrays rays, bool surface, int kernel, unsigned n_threads,
               nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  HitArrays hits(query.rays.size(), surface);
  if (surface)
    query.run(FirstHitQuery<Segments, At::surface>{query.tree, hits.columns()});
  else
    query.run(FirstHitQuery<Segments, At::closest>{query.tree, hits.columns()});
  return hits.tuple();
}

Output<bool> any_of(const LayoutView& layout, RayArrays rays, int kernel, unsigned n_threads, nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  auto found = make_array<bool>(query.rays.size());
  query.run(AnyHitQuery{found.data()});
  return found;
}

Output<std::int64_t> count(const LayoutView& layout, RayArrays rays, int kernel, unsigned n_threads,
                           nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  auto counts = make_array<std::int64_t>(query.rays.size());
  query.run(CountHitsQuery{counts.data()});
  return counts;
}

/// A quick look: `false` means that Python has to look closer.
bool check_rays(RayArrays rays, float largest_radius, float farthest, unsigned n_threads) {
  const WithoutGil without_gil;
  return rays_are_valid(batch_of(rays), largest_radius, farthest, n_threads);
}

}  // namespace

void bind_hits(nb::module_& m) {
  m.def("rays_are_valid", &check_rays, "rays"_a, "largest_radius"_a, "farthest"_a, "n_threads"_a);
  m.def("first_hit", &first, "layout"_a, "rays"_a, "surface"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("any_hit", &any_of, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("count_hits", &count, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
