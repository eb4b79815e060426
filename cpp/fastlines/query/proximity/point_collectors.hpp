// Collectors define the queries of points: the k nearest primitives, all within a radius, and their number. A search
// reports each piece of a primitive that passes the exact test, and the collector decides what counts.
//
// Primitives are ranked by their distance in the frame, then by id. A primitive can be reported by several leaves. Of
// an axis, the piece that owns s reports it. Of other shapes, and of rows with one owner, the best counts.
#pragma once

#include <algorithm>
#include <vector>

#include "../../rays/hit_order.hpp"
#include "../ray_collectors.hpp"
#include "point_query.hpp"
#include "seen.hpp"

namespace fastlines {

/// A primitive near a point.
struct Neighbour {
  float distance = kInfinity;  ///< in the frame
  std::uint32_t row = kNoPrim;
  float s = 0.0f;

  bool precedes(const Neighbour& other) const { return fastlines::precedes(distance, row, other.distance, other.row); }
  bool operator<(const Neighbour& other) const { return precedes(other); }
};

/// Records what is near one point.
template <class C>
concept PointCollector = requires(C& collector, const Neighbour& found, const Reference& ref) {
  /// Whether what is found lowers the limit, so that nearer nodes should be visited first.
  C::kShrinksLimit;
  /// A distance in the frame: what is farther need not be reported.
  collector.limit;
  /// Add what passes the exact test, and the piece that led to it.
  collector.add(found, ref);
};

/// Keeps the nearest primitive.
class NearestOfPoint {
 public:
  static constexpr bool kShrinksLimit = true;
  float limit;
  Neighbour best;

  NearestOfPoint(const PointQuery& query, std::size_t point, const Seen& seen)
      : limit(query.radius), point_(point), seen_(seen) {}

  void add(const Neighbour& found, const Reference&) {
    if (!found.precedes(best) || !seen_.sees(point_, found.row)) return;
    best = found;
    limit = std::min(limit, found.distance);
  }

 private:
  std::size_t point_;
  const Seen& seen_;
};

/// Keeps the k nearest primitives, in their order.
class KNearestOfPoint {
 public:
  static constexpr bool kShrinksLimit = true;
  float limit;

  /// `to` has room for k neighbours.
  KNearestOfPoint(const PointQuery& query, std::size_t point, const Seen& seen, std::span<Neighbour> to)
      : limit(query.radius), point_(point), seen_(seen), to_(to) {}

  /// What is found, in order.
  std::span<const Neighbour> found() const { return to_.first(size_); }

  void add(const Neighbour& found, const Reference& ref) {
    if (!(found.distance <= limit) || !owns(ref.s0, ref.s1, found.s) || !seen_.sees(point_, found.row)) return;
    Neighbour *const begin = to_.data(), *const end = begin + size_, *const place = std::lower_bound(begin, end, found);
    if (place == begin + to_.size()) return;
    Neighbour* gap = nullptr;  // the entry that gives way
    if (seen_.has_owners()) {
      const std::int64_t owner = seen_.owner_of(found.row);
      const auto is_same = [&](const Neighbour& other) { return seen_.owner_of(other.row) == owner; };
      if (std::any_of(begin, place, is_same)) return;
      if (Neighbour* const worse = std::find_if(place, end, is_same); worse != end) gap = worse;
    } else if (place != end && place->row == found.row && place->distance == found.distance) {
      return;  // a shape that another leaf has reported
    }
    if (!gap) gap = size_ < to_.size() ? begin + size_++ : end - 1;
    std::move_backward(place, gap, gap + 1);
    *place = found;
    if (size_ == to_.size()) limit = std::min(limit, to_.back().distance);
  }

 private:
  std::size_t point_;
  const Seen& seen_;
  std::span<Neighbour> to_;
  std::size_t size_ = 0;
};

/// Remove rows that a sorted list, which begins at `first`, has more than once, and all but the best of each owner.
inline void remove_repeats(const Seen& seen, bool repeats, std::vector<Neighbour>& list, std::size_t first) {
  const auto begin = list.begin() + std::ptrdiff_t(first);
  if (seen.has_owners()) {
    const auto owner = [&](const Neighbour& of) { return seen.owner_of(of.row); };
    std::stable_sort(begin, list.end(), [&](const auto& a, const auto& b) { return owner(a) < owner(b); });
    const auto is_same = [&](const Neighbour& a, const Neighbour& b) { return owner(a) == owner(b); };
    list.erase(std::unique(begin, list.end(), is_same), list.end());
    std::sort(begin, list.end());
  } else if (repeats) {
    const auto is_same = [](const Neighbour& a, const Neighbour& b) { return a.row == b.row; };
    list.erase(std::unique(begin, list.end(), is_same), list.end());
  }
}

/// Lists all primitives within the radius of a point.
class WithinOfPoint {
 public:
  static constexpr bool kShrinksLimit = false;
  float limit;

  /// Appends to a list. `repeats` says whether shapes are reported more than once.
  WithinOfPoint(const PointQuery& query, std::size_t point, const Seen& seen, bool repeats, std::vector<Neighbour>& to)
      : limit(query.radius), point_(point), seen_(seen), repeats_(repeats), to_(to), first_(to.size()) {}

  void add(const Neighbour& found, const Reference& ref) {
    if (owns(ref.s0, ref.s1, found.s) && seen_.sees(point_, found.row)) to_.push_back(found);
  }

  /// Sort the list of this point, and remove what is there more than once. Call it at the end.
  void finish() {
    std::sort(to_.begin() + std::ptrdiff_t(first_), to_.end());
    remove_repeats(seen_, repeats_, to_, first_);
  }

  std::size_t size() const { return to_.size() - first_; }

 private:
  std::size_t point_;
  const Seen& seen_;
  bool repeats_;
  std::vector<Neighbour>& to_;
  std::size_t first_;
};

/// Counts the primitives within the radius of a point, where each is reported by its owner alone.
class CountOfPoint {
 public:
  static constexpr bool kShrinksLimit = false;
  float limit;
  std::size_t n = 0;

  CountOfPoint(const PointQuery& query, std::size_t point, const Seen& seen)
      : limit(query.radius), point_(point), seen_(seen) {}

  void add(const Neighbour& found, const Reference& ref) {
    n += owns(ref.s0, ref.s1, found.s) && seen_.sees(point_, found.row);
  }

 private:
  std::size_t point_;
  const Seen& seen_;
};

}  // namespace fastlines
