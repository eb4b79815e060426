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

/// What is known of the rows of a set: the primitive of each, or None if each row is one; its number in the whole, or
/// None if the set is no part of one; and its place along a strand (strand, position, period), or None if no neighbours
/// are left out.
using RowArrays = std::tuple<std::optional<Input<std::int64_t>>, std::optional<Input<std::int64_t>>,
                             std::optional<Input<std::int32_t>>>;

/// Those of the first and of the second set.
using BothRowArrays = std::tuple<RowArrays, RowArrays>;

/// The radius; whether surfaces count; by how much the positions of neighbours along a strand differ at most; the first
/// primitives, from begin up to end; and how many pairs there may be.
using PairOptions = std::tuple<float, bool, std::int32_t, std::int64_t, std::int64_t, std::size_t>;

/// Columns of pairs: the rows i and j, s, t, and the distance.
using PairTuple = std::tuple<Output<std::int64_t>, Output<std::int64_t>, Output<float>, Output<float>, Output<float>>;

template <class T>
std::span<const T> rows_or_none(const auto& array) {
  return array ? rows<T>(*array) : std::span<const T>();
}

inline AxisSet axes_of_any(const QueryPrimitives& prims, const RowArrays& known) {
  const auto owner = rows_or_none<std::int64_t>(std::get<0>(known));
  return std::visit(
      [&]<class P>(const P& of) -> AxisSet {
        if constexpr (ProximityPrimitive<P>)
          return axes_of(of, owner);
        else
          throw std::invalid_argument(std::string("queries about pairs do not know ") + P::kKind);
      },
      prims);
}

inline PairQuery pair_query(const QueryPrimitives& first, const QueryPrimitives& second, bool is_self,
                            const Frame& frame, const BothRowArrays& known, const PairOptions& options) {
  using Place = StrandNeighbours::Place;
  const auto& [of_first, of_second] = known;
  const auto [radius, surface, reach, begin, end, max_pairs] = options;
  PairQuery query{axes_of_any(first, of_first), axes_of_any(second, of_second), is_self, frame, radius, surface};
  query.numbers = {rows_or_none<std::int64_t>(std::get<1>(of_first)),
                   rows_or_none<std::int64_t>(std::get<1>(of_second))};
  query.neighbours = {rows_or_none<Place>(std::get<2>(of_first)), rows_or_none<Place>(std::get<2>(of_second)), reach};
  query.begin = begin;
  query.end = end;
  query.max_pairs = max_pairs;
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
