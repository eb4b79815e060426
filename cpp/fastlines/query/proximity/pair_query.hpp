// What a query for pairs asks for: a radius, and the pairs that it leaves out.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <span>

#include "axis_set.hpp"

namespace fastlines {

/// Neighbours along strands, which a self-join leaves out.
struct StrandNeighbours {
  /// The strand of a row, -1 for none, and the position of its primitive along it.
  struct Place {
    std::int32_t strand, position;
  };
  std::span<const Place> places;          ///< of each row; empty if none is left out
  std::span<const std::int32_t> periods;  ///< of each strand: the number of its primitives if it is closed, else 0
  std::int32_t reach = 0;                 ///< the positions of neighbours differ by at most this

  bool has(std::uint32_t i, std::uint32_t j) const {
    if (places.empty()) return false;
    const Place &a = places[i], &b = places[j];
    if (a.strand != b.strand || a.strand < 0) return false;
    const std::int32_t apart = std::abs(a.position - b.position), period = periods[std::size_t(a.strand)];
    return (period > 0 ? std::min(apart, period - apart) : apart) <= reach;
  }
};

/// All pairs of a primitive of `first` and one of `second` whose distance is at most `radius`. In a self-join both are
/// the same set: each pair counts once, and its first primitive is the one with the lower id.
struct PairQuery {
  AxisSet first, second;
  bool is_self;
  Frame frame;
  float radius;  ///< in units of the scene
  bool surface;  ///< whether radii count
  StrandNeighbours neighbours;
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
    return !is_self || (first.owner_of(i) != second.owner_of(j) && !neighbours.has(i, j));
  }
};

/// Thrown if there are more pairs than `PairQuery::max_pairs`.
struct TooManyPairs : std::exception {
  const char* what() const noexcept override { return "more pairs than may be in memory"; }
};

}  // namespace fastlines
