// Pairs of near primitives by brute force, one pair at a time: what defines them.
#include "core.hpp"
#include "fastlines/query/proximity/all_pairs.hpp"
#include "layout.hpp"
#include "pairs.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// A kind of primitives, and their rows.
using KindAndRows = std::tuple<std::string, Input<float>>;

Box bounds_of(const QueryPrimitives& prims) {
  return std::visit([](const auto& of) { return bounds_of_all(of); }, prims);
}

/// The pairs within a radius, sorted; of one set of primitives with another, or with itself.
PairTuple brute_pairs(const KindAndRows& prims, std::optional<KindAndRows> other, BothRowArrays known,
                      PairOptions options, unsigned n_threads, nb::object progress) {
  const auto set_of = [](const KindAndRows& of) {
    return ray_primitives<QueryPrimitives>(std::get<0>(of), std::get<1>(of));
  };
  const QueryPrimitives first = set_of(prims), second = set_of(other ? *other : prims);
  Box box = bounds_of(first);
  box.grow(bounds_of(second));
  const PairQuery query = pair_query(first, second, !other, frame_of(box), known, options);
  return watch_pairs(progress, [&](Progress& watched) { return all_pairs<float>(query, n_threads, watched); });
}

}  // namespace

void bind_pairs(nb::module_& m) {
  m.def("brute_force_pairs", &brute_pairs, "prims"_a, "other"_a.none(), "known"_a, "options"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
