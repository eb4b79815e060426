// Queries on the wide layout.
#include <nanobind/stl/optional.h>

#include "engine.hpp"
#include "engine/layout_queries.hpp"
#include "fastlines/rays/ray_check.hpp"
#include "layout.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Calls run(queries) with the LayoutQueries of a batch of rays. A short batch runs on one thread.
template <class Run>
void run_queries(const LayoutView& layout, const RayBatch& rays, int kernel, unsigned n_threads,
                 const nb::object& progress, Run&& run) {
  const bool is_long = may_be_long(rays.size(), layout.refs.size());
  layout.with_view([&]<class P>(const WideBvhView<P>& view) {
    if constexpr (kHasQueries<P>)
      watch_if(is_long, progress, [&](Progress& watched) {
        watched.per_step = 1.0 / (double(rays.size()) * double(layout.leaves.size()));
        run(LayoutQueries<P>{view, rays, Kernel(kernel), is_long ? n_threads : 1, watched});
      });
    else
      throw std::invalid_argument(std::string("this module is compiled for segments alone, not for ") + P::kKind);
  });
}

HitTuple first(const LayoutView& layout, RayArrays rays, const std::string& at_name, int kernel, unsigned n_threads,
               nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const At at = at_of(at_name);
  HitArrays hits(batch.size(), has_exit(at));
  run_queries(layout, batch, kernel, n_threads, progress,
              [&](const auto& queries) { queries.find_first(at, hits.columns()); });
  return hits.tuple();
}

/// The first crossings of rays with the primitives that pieces belong to, as hits of the pieces that begin them.
/// `owner` has the primitive of each piece.
HitTuple first_crossing(const LayoutView& layout, RayArrays rays, Input<std::int64_t> owner, const std::string& at_name,
                        int kernel, unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const At at = at_of(at_name);
  if (!has_exit(at)) throw std::invalid_argument("at is closest; expected surface or entry");
  HitArrays hits(batch.size(), true);
  run_queries(layout, batch, kernel, n_threads, progress, [&](const auto& queries) {
    queries.find_first_crossing(at, {rows<std::int64_t>(owner)}, hits.columns());
  });
  return hits.tuple();
}

Output<bool> any_of(const LayoutView& layout, RayArrays rays, const std::string& at_name, int kernel,
                    unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const At at = at_of(at_name);
  auto found = make_array<bool>(batch.size());
  run_queries(layout, batch, kernel, n_threads, progress,
              [&](const auto& queries) { queries.find_any(at, found.data()); });
  return found;
}

Output<std::int64_t> count(const LayoutView& layout, RayArrays rays, const std::string& at_name, int kernel,
                           unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const At at = at_of(at_name);
  auto counts = make_array<std::int64_t>(batch.size());
  run_queries(layout, batch, kernel, n_threads, progress,
              [&](const auto& queries) { queries.count(at, counts.data()); });
  return counts;
}

/// All hits of each ray, or its first k by t if k is given, or the k nearest to it with `by_distance`.
ListTuple list(const LayoutView& layout, RayArrays rays, const std::string& at_name, std::optional<std::size_t> k,
               bool by_distance, int kernel, unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const At at = at_of(at_name);
  std::optional<HitAssembler> lists;
  run_queries(layout, batch, kernel, n_threads, progress, [&](const auto& queries) {
    queries.list(at, k, by_distance, lists.emplace(batch.size(), has_exit(at)));
  });
  return arrays_of(*lists);
}

/// A quick check of all rays, and a checksum. After `false`, Python has to find out which rays are invalid, if any.
std::tuple<bool, std::uint64_t> check(RayArrays rays, float largest_radius, float farthest, unsigned n_threads) {
  const WithoutGil without_gil;
  const auto [valid, digest] = check_rays(batch_of(rays), largest_radius, farthest, n_threads);
  return {valid, digest};
}

}  // namespace

void bind_queries(nb::module_& m) {
  m.def("check_rays", &check, "rays"_a, "largest_radius"_a, "farthest"_a, "n_threads"_a);
  m.def("first_hit", &first, "layout"_a, "rays"_a, "at"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("first_crossing", &first_crossing, "layout"_a, "rays"_a, "owner"_a, "at"_a, "kernel"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("any_hit", &any_of, "layout"_a, "rays"_a, "at"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("count_hits", &count, "layout"_a, "rays"_a, "at"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("list_hits", &list, "layout"_a, "rays"_a, "at"_a, "k"_a.none(), "by_distance"_a, "kernel"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
