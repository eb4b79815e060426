// What a query for pairs asks for: a radius, and the pairs that it leaves out.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <span>

#include "axis_set.hpp"

namespace fastlines {

/// Neighbours along strands, which pairs of one whole leave out.
struct StrandNeighbours {
  /// The strand of a row, -1 for none; the position of its primitive along it; and the number of primitives that the
  /// strand has if it is closed, else 0.
  struct Place {
    std::int32_t strand, position, period;
  };
  std::span<const Place> first, second;  ///< of each row of both sets; empty if none is left out
  std::int32_t reach = 0;                ///< the positions of neighbours differ by at most this

  bool has(std::uint32_t i, std::uint32_t j) const {
    if (first.empty()) return false;
    const Place &a = first[i], &b = second[j];
    if (a.strand != b.strand || a.strand == -1) return false;
    const std::int32_t apart = std::abs(a.position - b.position);
    return (a.period > 0 ? std::min(apart, a.period - apart) : apart) <= reach;
  }
};

/// Two sets as parts of one whole: the number there of each of their primitives.
struct WholeNumbers {
  std::span<const std::int64_t> first, second;  ///< rising; empty if the sets are no parts
  bool are_known() const { return !first.empty(); }
};

/// All pairs of a primitive of `first` and one of `second` whose distance is at most `radius`. In a self-join both are
/// the same set: each pair counts once, and its first primitive is the one with the lower id. So it is for parts of one
/// whole: a second query, with both exchanged, finds the pairs whose first primitive is in the other part.
struct PairQuery {
  AxisSet first, second;
  bool is_self;
  Frame frame;
  float radius;  ///< in units of the scene
  bool surface;  ///< whether radii count
  StrandNeighbours neighbours = {};
  WholeNumbers numbers = {};
  /// The first primitive of a pair is in [begin, end).
  std::int64_t begin = 0, end = INT64_MAX;
  std::size_t max_pairs = ~std::size_t(0);

  bool has_range() const { return begin > 0 || end < std::int64_t(first.n_prims()); }
  bool has_pieces() const { return !first.owner.empty() || !second.owner.empty(); }
  float frame_radius() const { return radius * frame.scale; }

  /// Whether a row can be the first of a pair.
  bool is_first(std::uint32_t i) const { return begin <= first.owner_of(i) && first.owner_of(i) < end; }

  /// Whether a pair of rows counts, whatever its distance is. In a self-join i < j.
  bool counts(std::uint32_t i, std::uint32_t j) const {
    if (!is_first(i)) return false;
    if (is_self) return first.owner_of(i) != second.owner_of(j) && !neighbours.has(i, j);
    return !numbers.are_known() || (numbers.first[i] < numbers.second[j] && !neighbours.has(i, j));
  }
};

/// Thrown if there are more pairs than `PairQuery::max_pairs`.
struct TooManyPairs : std::exception {
  const char* what() const noexcept override { return "more pairs than may be in memory"; }
};

}  // namespace fastlines
