// Queries on the wide layout.
#include <nanobind/stl/optional.h>

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
  const auto run_at = [&]<At at>() {
    query.run([&]<class P>(const WideBvhView<P>& view) { return FirstHitQuery<P, at>{view, hits.columns()}; });
  };
  surface ? run_at.template operator()<At::surface>() : run_at.template operator()<At::closest>();
  return hits.tuple();
}

Output<bool> any_of(const LayoutView& layout, RayArrays rays, int kernel, unsigned n_threads, nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  auto found = make_array<bool>(query.rays.size());
  query.run([&](const auto&) { return AnyHitQuery{found.data()}; });
  return found;
}

Output<std::int64_t> count(const LayoutView& layout, RayArrays rays, int kernel, unsigned n_threads,
                           nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  auto counts = make_array<std::int64_t>(query.rays.size());
  query.run([&](const auto&) { return CountHitsQuery{counts.data()}; });
  return counts;
}

/// All hits of each ray, or its k nearest if k is given.
ListTuple list(const LayoutView& layout, RayArrays rays, bool surface, std::optional<std::size_t> k, int kernel,
               unsigned n_threads, nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  const auto list_at = [&]<At at>() {
    if (k) return query.list<at>([&]<class P>(const WideBvhView<P>& view) { return KNearestQuery<P, at>(view, *k); });
    return query.list<at>([&]<class P>(const WideBvhView<P>& view) { return AllHitsQuery<P, at>(view); });
  };
  return surface ? list_at.template operator()<At::surface>() : list_at.template operator()<At::closest>();
}

/// A quick check of all rays. After `false`, Python has to find out which rays are invalid, if any.
bool check_rays(RayArrays rays, float largest_radius, float farthest, unsigned n_threads) {
  const WithoutGil without_gil;
  return rays_are_valid(batch_of(rays), largest_radius, farthest, n_threads);
}

}  // namespace

void bind_queries(nb::module_& m) {
  m.def("rays_are_valid", &check_rays, "rays"_a, "largest_radius"_a, "farthest"_a, "n_threads"_a);
  m.def("first_hit", &first, "layout"_a, "rays"_a, "surface"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("any_hit", &any_of, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("count_hits", &count, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("list_hits", &list, "layout"_a, "rays"_a, "surface"_a, "k"_a.none(), "kernel"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
