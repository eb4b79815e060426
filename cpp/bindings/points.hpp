// Points as NumPy arrays, and the queries of points, on a layout or by brute force.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "fastlines/query/proximity/for_each_point.hpp"
#include "fastlines/rays/spread_ray.hpp"
#include "sequences.hpp"
#include "watch.hpp"

namespace fastlines {

/// What points see (query/proximity/seen.hpp): hidden rows; the owner of each row; and numbers that each point leaves
/// out, (n_points, m), with the number of each row.
using IgnoredArrays = std::tuple<Input<std::int64_t>, std::optional<Input<std::int64_t>>>;
using SeenArrays =
    std::tuple<std::optional<Input<std::uint8_t>>, std::optional<Input<std::int64_t>>, Sequence<IgnoredArrays>>;

/// What the arrays say; `ignored` holds the elements of their sequence.
inline Seen seen_of(const SeenArrays& arrays, const std::vector<IgnoredArrays>& ignored) {
  const auto& hidden = std::get<0>(arrays);
  const auto& owner = std::get<1>(arrays);
  Seen seen;
  if (ignored.size() > std::size(seen.ignored)) throw std::invalid_argument("points leave out two kinds at most");
  if (hidden) seen.hidden = rows<std::uint8_t>(*hidden);
  if (owner) seen.owner = rows<std::int64_t>(*owner);
  for (std::size_t i = 0; i < ignored.size(); ++i) {
    const auto& [numbers, of_row] = ignored[i];
    seen.ignored[i] = {numbers.data(), numbers.shape(1), {}};
    if (of_row) seen.ignored[i].of_row = rows<std::int64_t>(*of_row);
  }
  return seen;
}

/// Columns of what is near points: distances, rows, and s.
using NearTuple = std::tuple<Output<float>, Output<std::int64_t>, Output<float>>;

/// The queries of points on a `View`, as functions for Python: with_points(view, use) calls use(search) with a search
/// (for_each_point.hpp).
template <class View>
struct PointFunctions {
  /// Calls run(query) with the `PointsQuery`.
  template <class Run>
  static void run_query(const View& view, const Input<double>& points, const Input<float>& radius, bool surface,
                        const SeenArrays& seen_arrays, unsigned n_threads, const nanobind::object& progress,
                        Run&& run) {
    const PointBatch batch{rows<double>(points), rows<float>(radius), surface};
    const std::vector<IgnoredArrays> ignored = vector_of<IgnoredArrays>(std::get<2>(seen_arrays));
    const Seen seen = seen_of(seen_arrays, ignored);
    with_points(view, [&](const auto& search) {
      const bool is_long = may_be_long(batch.size(), search.n_steps());
      watch_if(is_long, progress, [&](Progress& watched) {
        watched.per_step = 1.0 / (double(batch.size()) * double(search.n_steps() + 1));
        run(PointsQuery<std::remove_cvref_t<decltype(search)>>{search, batch, seen, is_long ? n_threads : 1, watched});
      });
    });
  }

  static NearTuple nearest(const View& view, Input<double> points, Input<float> max_distance, std::size_t k,
                           bool surface, SeenArrays seen, unsigned n_threads, nanobind::object progress) {
    const std::size_t n = points.shape(0) * k;
    auto distance = make_array<float>(n), s = make_array<float>(n);
    auto row = make_array<std::int64_t>(n);
    run_query(view, points, max_distance, surface, seen, n_threads, progress,
              [&](const auto& query) { query.find_nearest(k, {distance.data(), row.data(), s.data()}); });
    return {distance, row, s};
  }

  static std::tuple<Output<std::int64_t>, NearTuple> within(const View& view, Input<double> points, Input<float> radius,
                                                            bool surface, SeenArrays seen, unsigned n_threads,
                                                            nanobind::object progress) {
    PointLists lists;
    run_query(view, points, radius, surface, seen, n_threads, progress,
              [&](const auto& query) { lists = query.list(); });
    return {adopt<std::int64_t>(std::move(lists.offsets)),
            {adopt<float>(std::move(lists.distance)), adopt<std::int64_t>(std::move(lists.row)),
             adopt<float>(std::move(lists.s))}};
  }

  static Output<std::int64_t> count(const View& view, Input<double> points, Input<float> radius, bool surface,
                                    SeenArrays seen, unsigned n_threads, nanobind::object progress) {
    auto counts = make_array<std::int64_t>(points.shape(0));
    run_query(view, points, radius, surface, seen, n_threads, progress,
              [&](const auto& query) { query.count(counts.data()); });
    return counts;
  }
};

template <class View>
void bind_points(nanobind::module_& m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  using Functions = PointFunctions<View>;
  m.def("nearest", &Functions::nearest, "view"_a, "points"_a.noconvert(), "max_distance"_a, "k"_a, "surface"_a,
        "seen"_a, "n_threads"_a, "progress"_a.none());
  m.def("within", &Functions::within, "view"_a, "points"_a.noconvert(), "radius"_a, "surface"_a, "seen"_a,
        "n_threads"_a, "progress"_a.none());
  m.def("count_within", &Functions::count, "view"_a, "points"_a.noconvert(), "radius"_a, "surface"_a, "seen"_a,
        "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
