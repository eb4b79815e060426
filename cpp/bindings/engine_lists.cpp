// Queries with a list of hits for each ray: all of them, or the k nearest.
#include <nanobind/stl/optional.h>

#include "engine.hpp"
#include "query.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// All hits, or with k those that are nearest.
ListTuple list(const LayoutView& layout, RayArrays rays, bool surface, std::optional<std::size_t> k, int kernel,
               unsigned n_threads, nb::object progress) {
  const BatchQuery query(layout, rays, kernel, n_threads, progress);
  const auto list_at = [&]<At at>() {
    return k ? query.list<at>(KNearestQuery<Segments, at>(query.tree, *k))
             : query.list<at>(AllHitsQuery<Segments, at>(query.tree));
  };
  return surface ? list_at.template operator()<At::surface>() : list_at.template operator()<At::closest>();
}

}  // namespace

void bind_lists(nb::module_& m) {
  m.def("list_hits", &list, "layout"_a, "rays"_a, "surface"_a, "k"_a.none(), "kernel"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
