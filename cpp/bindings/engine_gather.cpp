// Sums over all hits of each ray: on the wide layout, and over lists of hits that any search has found.
#include "engine.hpp"
#include "engine/layout_queries.hpp"
#include "fastlines/query/gather/gather_lists.hpp"
#include "gather.hpp"
#include "layout.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Nothing if the kind of primitive is not lines alone: hits then have to be listed.
std::optional<GatherTuple> gather(const LayoutView& layout, RayArrays rays, GatherArrays arrays, bool with_squares,
                                  int kernel, unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const GatherRule rule = rule_of(arrays);
  GatherOutput to(batch.size(), rule.n_channels, with_squares);
  const bool is_long = may_be_long(batch.size(), layout.refs.size());
  return layout.with_view([&]<class P>(const WideBvhView<P>& view) -> std::optional<GatherTuple> {
    if constexpr (kHasQueries<P> && AxisPrimitive<P>) {
      watch_if(is_long, progress, [&](Progress& watched) {
        watched.per_step = 1.0 / (double(batch.size()) * double(layout.leaves.size()));
        LayoutQueries<P>{view, batch, Kernel(kernel), is_long ? n_threads : 1, watched}.gather(rule, to.sums());
      });
      return to.tuple();
    } else {
      return {};
    }
  });
}

/// Hits of all rays: offsets, t, prim, u and the distance.
using HitLists = std::tuple<Input<std::int64_t>, Input<float>, Input<std::int64_t>, Input<float>, Input<float>>;

/// `lines` has a row for each hit: both ends of its line, and the radius at each.
GatherTuple gather_listed(RayArrays rays, HitLists hits, Input<float> lines, GatherArrays arrays, bool with_squares,
                          unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const GatherRule rule = rule_of(arrays);
  const auto& [offsets, t, prim, u, distance] = hits;
  const ListedHits listed{rows<std::int64_t>(offsets), rows<std::int64_t>(prim), rows<float>(t), rows<float>(u),
                          rows<float>(distance)};
  GatherOutput to(batch.size(), rule.n_channels, with_squares);
  const bool is_long = may_be_long(batch.size(), listed.prim.size());
  watch_if(is_long, progress, [&](Progress& watched) {
    gather_lists(rule, batch, listed, {lines.data(), std::size_t(lines.shape(1))}, to.sums(), is_long ? n_threads : 1,
                 watched);
  });
  return to.tuple();
}

}  // namespace

void bind_gather(nb::module_& m) {
  m.def("gather", &gather, "layout"_a, "rays"_a, "rule"_a, "with_squares"_a, "kernel"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("gather_lists", &gather_listed, "rays"_a, "hits"_a, "lines"_a, "rule"_a, "with_squares"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
