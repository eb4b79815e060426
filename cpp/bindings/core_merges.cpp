// Answers of the parts of a whole, merged: pairs, and what is near points or in boxes.
#include "core.hpp"
#include "fastlines/query/proximity/merge_lists.hpp"
#include "fastlines/query/proximity/merge_pairs.hpp"
#include "pairs.hpp"
#include "sequences.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// A sorted list of pairs: i, j, s, t, and the distance.
using RunArrays = std::tuple<Input<std::int64_t>, Input<std::int64_t>, Input<float>, Input<float>, Input<float>>;

PairTuple merged_pairs(Sequence<RunArrays> lists, unsigned n_threads, nb::object progress) {
  const std::vector<RunArrays> arrays = vector_of<RunArrays>(lists);
  std::vector<PairRun> runs;
  for (const auto& [i, j, s, t, distance] : arrays)
    runs.push_back(
        {rows<std::int64_t>(i), rows<std::int64_t>(j), rows<float>(s), rows<float>(t), rows<float>(distance)});
  return watch_pairs(progress, [&](Progress& watched) { return PairMerge(runs).merged(n_threads, watched); });
}

/// The points that a part answers, offsets and primitives, and the distances and s, if lists have these.
using PartArrays = std::tuple<Input<std::int64_t>, Input<std::int64_t>, Input<std::int64_t>,
                              std::optional<Input<float>>, std::optional<Input<float>>>;

/// Offsets, primitives, distances and s; these are empty where the parts have none.
using MergedTuple = std::tuple<Output<std::int64_t>, Output<std::int64_t>, Output<float>, Output<float>>;

MergedTuple merged_lists(std::size_t n_points, Sequence<PartArrays> lists, bool has_distance, unsigned n_threads,
                         nb::object progress) {
  const std::vector<PartArrays> arrays = vector_of<PartArrays>(lists);
  std::vector<PartLists> parts;
  for (const auto& [points, offsets, prims, distance, s] : arrays)
    parts.push_back({rows<std::int64_t>(points), rows<std::int64_t>(offsets), rows<std::int64_t>(prims),
                     rows_or_none<float>(distance), rows_or_none<float>(s)});
  MergedLists found;
  watch([&](Progress& watched) { found = merge_lists(n_points, parts, has_distance, n_threads, watched); }, progress);
  return {adopt<std::int64_t>(std::move(found.offsets)), adopt<std::int64_t>(std::move(found.prims)),
          adopt<float>(std::move(found.distance)), adopt<float>(std::move(found.s))};
}

template <class Scalar>
using Written = nb::ndarray<Scalar, nb::c_contig, nb::device::cpu>;

/// Columns of (n, k): distances, primitives and s.
using BestArrays = std::tuple<Written<float>, Written<std::int64_t>, Written<float>>;
using NearArrays = std::tuple<Input<float>, Input<std::int64_t>, Input<float>>;

void merge_nearest_of(const BestArrays& best, std::size_t k, const Input<std::int64_t>& points,
                      const NearArrays& found) {
  const auto& [best_distance, best_prim, best_s] = best;
  const auto& [distance, prim, s] = found;
  const std::size_t n = points.size();
  const WithoutGil without_gil;
  merge_nearest({best_distance.data(), best_prim.data(), best_s.data(), k}, rows<std::int64_t>(points),
                {distance.data(), prim.data(), s.data(), n == 0 ? 0 : distance.size() / n});
}

}  // namespace

void bind_merges(nb::module_& m) {
  m.def("merge_pairs", &merged_pairs, "lists"_a, "n_threads"_a, "progress"_a.none());
  m.def("merge_lists", &merged_lists, "n_points"_a, "lists"_a, "has_distance"_a, "n_threads"_a, "progress"_a.none());
  m.def("merge_nearest", &merge_nearest_of, "best"_a, "k"_a, "points"_a, "found"_a);
}

}  // namespace fastlines
