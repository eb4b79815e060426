// Pairs of near primitives, on wide layouts and by brute force.
#include "engine.hpp"
#include "engine/pair_queries.hpp"
#include "layout.hpp"
#include "pairs.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

PairTree tree_of(const LayoutView& layout) {
  Frame frame = layout.frame;
  layout.with_view([&](const auto& view) { frame.overhang = view.frame.overhang; });
  return {frame, layout.nodes, layout.leaves, layout.refs};
}

/// Calls find(query, first, second) for the pairs of two layouts, or of one.
template <class Find>
PairTuple query_pairs(const LayoutView& layout, const LayoutView* other, const BothRowArrays& known,
                      const PairOptions& options, const nb::object& progress, Find&& find) {
  const LayoutView& second = other ? *other : layout;
  Box box = layout.frame_box;
  box.grow(second.frame_box);
  const PairQuery query = pair_query(layout.prims, second.prims, !other, frame_of(box), known, options);
  return watch_pairs(progress, [&](Progress& watched) { return find(query, second, watched); });
}

/// The pairs within a radius, sorted. A layout without leaves stands for its primitives, in blocks of 16.
PairTuple pairs(const LayoutView& layout, const LayoutView* other, BothRowArrays known, PairOptions options,
                unsigned n_threads, nb::object progress) {
  return query_pairs(layout, other, known, options, progress,
                     [&](const PairQuery& query, const LayoutView& second, Progress& watched) {
                       return find_pairs(query, tree_of(layout), tree_of(second), n_threads, watched);
                     });
}

/// The same by brute force, 16 pairs at a time.
PairTuple brute_pairs(const LayoutView& layout, const LayoutView* other, BothRowArrays known, PairOptions options,
                      unsigned n_threads, nb::object progress) {
  return query_pairs(layout, other, known, options, progress,
                     [&](const PairQuery& query, const LayoutView&, Progress& watched) {
                       return test_all_pairs(query, n_threads, watched);
                     });
}

}  // namespace

void bind_pairs(nb::module_& m) {
  m.def("pairs", &pairs, "layout"_a, "other"_a.none(), "known"_a, "options"_a, "n_threads"_a, "progress"_a.none());
  m.def("brute_force_pairs", &brute_pairs, "layout"_a, "other"_a.none(), "known"_a, "options"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
