// Queries for pairs and their answers as NumPy arrays.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <new>

#include "arrays.hpp"
#include "fastlines/primitives/point_test.hpp"
#include "fastlines/query/proximity/pair_list.hpp"
#include "primitives.hpp"
#include "watch.hpp"

namespace fastlines {

/// The primitive of each row of the first and of the second set, or None if each row is one.
using OwnerArrays = std::tuple<std::optional<Input<std::int64_t>>, std::optional<Input<std::int64_t>>>;

/// What a self-join leaves out: the strand and the position of each row, (n, 2); the periods of strands; and by how
/// much the positions of neighbours differ at most.
using NeighbourArrays = std::optional<std::tuple<Input<std::int32_t>, Input<std::int32_t>, std::int32_t>>;

/// The radius; whether surfaces count; the first primitives, from begin up to end; and how many pairs there may be.
using PairOptions = std::tuple<float, bool, std::int64_t, std::int64_t, std::size_t>;

/// Columns of pairs: the rows i and j, s, t, and the distance.
using PairTuple = std::tuple<Output<std::int64_t>, Output<std::int64_t>, Output<float>, Output<float>, Output<float>>;

inline AxisSet axes_of_any(const QueryPrimitives& prims, const std::optional<Input<std::int64_t>>& owner) {
  const auto owners = owner ? rows<std::int64_t>(*owner) : std::span<const std::int64_t>();
  return std::visit(
      [&]<class P>(const P& of) -> AxisSet {
        if constexpr (ProximityPrimitive<P>)
          return axes_of(of, owners);
        else
          throw std::invalid_argument(std::string("queries about pairs do not know ") + P::kKind);
      },
      prims);
}

inline PairQuery pair_query(const AxisSet& first, const AxisSet& second, bool is_self, const Frame& frame,
                            const NeighbourArrays& neighbours, const PairOptions& options) {
  const auto [radius, surface, begin, end, max_pairs] = options;
  PairQuery query{first, second, is_self, frame, radius, surface, {}, begin, end, max_pairs};
  if (neighbours) {
    const auto& [places, periods, reach] = *neighbours;
    query.neighbours = {rows<StrandNeighbours::Place>(places), rows<std::int32_t>(periods), reach};
  }
  return query;
}

/// Calls find(progress), which returns the columns, without the GIL. More pairs than allowed raise a MemoryError.
template <class Find>
PairTuple watch_pairs(const nanobind::object& progress, Find&& find) {
  PairColumns found;
  watch(
      [&](Progress& watched) {
        try {
          found = find(watched);
        } catch (const TooManyPairs&) {
          throw std::bad_alloc();
        }
      },
      progress);
  return {adopt<std::int64_t>(std::move(found.i)), adopt<std::int64_t>(std::move(found.j)),
          adopt<float>(std::move(found.s)), adopt<float>(std::move(found.t)), adopt<float>(std::move(found.distance))};
}

}  // namespace fastlines
