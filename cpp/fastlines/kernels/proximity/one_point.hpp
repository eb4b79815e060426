// Answers queries about one point on the calling thread, for programs that ask about one point at a time, and calls a
// function for what is near a point.
//
//     const PointQuery point = prepare_point(coordinates, radius, /*surface=*/false, tree.frame);
//     std::size_t n = 0;
//     traverse_near(tree, point, [&](const Neighbour& found, const Reference& piece, float& limit) {
//       n += owns(piece.s0, piece.s1, found.s) && is_wanted(piece.prim);
//     });
//
// counts the wanted primitives within the radius.
#pragma once

#include <concepts>
#include <memory>

#include "../../memory/thread_scratch.hpp"
#include "point_search.hpp"

namespace fastlines {

/// Report what is near a point to the collector, nearest node first. The point is prepared for the tree's frame
/// (`prepare_point`).
template <RayPrimitive P, PointCollector C>
void traverse_near(const WideBvhView<P>& tree, const PointQuery& point, C& to) {
  struct Kept {
    Progress progress;
    Checkpoint checkpoint{progress};
    typename PointSearch<P>::Scratch scratch;
  };
  // A thread keeps its stack from call to call. A traversal within another one's `add` gets a stack of its own.
  auto& spare = thread_scratch<std::unique_ptr<Kept>>();
  std::unique_ptr<Kept> kept = std::move(spare);
  if (!kept) kept = std::make_unique<Kept>();
  kept->scratch.last = kNoPrim;
  PointSearch<P>(tree, 0)(point, to, kept->scratch, kept->checkpoint);
  spare = std::move(kept);
}

/// The collector of a function.
template <class Visit>
struct VisitNear {
  static constexpr bool kShrinksLimit = true;
  float limit;
  Visit& visit;

  void add(const Neighbour& found, const Reference& ref) {
    if (found.distance <= limit) visit(found, ref, limit);
  }
};

/// Call visit(found, piece, limit) for each primitive within the radius of a point, nearest node first. `found` is in
/// the frame of the tree: a distance divided by `tree.frame.scale` is in units of the scene. `piece` is the part of the
/// primitive that led to it.
///
/// A line that is in several leaves is reported for each, and one of its pieces owns the place: `owns(piece.s0,
/// piece.s1, found.s)`. Only an `AxisPrimitive` has such pieces; any other may be reported several times.
///
/// The function may lower `limit`, the distance in the frame beyond which nothing is needed. −infinity ends the
/// reports.
template <RayPrimitive P, class Visit>
  requires std::invocable<Visit&, const Neighbour&, const Reference&, float&>
void traverse_near(const WideBvhView<P>& tree, const PointQuery& point, Visit&& visit) {
  VisitNear<std::remove_reference_t<Visit>> collector{point.radius, visit};
  traverse_near(tree, point, collector);
}

/// A point that is prepared for a tree, and what it sees, as point 0 of `Seen`. Preconditions: the point is finite, and
/// the radius is not negative.
template <RayPrimitive P>
class OnePoint {
 public:
  OnePoint(const WideBvhView<P>& tree, const PointQuery& point, const Seen& seen = Seen())
      : tree_(tree), point_(point), seen_(seen) {}

  /// The nearest primitive. If there is none, its row is kNoPrim.
  Neighbour nearest() const {
    NearestOfPoint nearest(point_, 0, seen_);
    traverse_near(tree_, point_, nearest);
    return nearest.best;
  }

  /// Replace `to` by the k nearest primitives, in their order.
  void k_nearest(std::size_t k, std::vector<Neighbour>& to) const {
    to.resize(k);
    KNearestOfPoint nearest(point_, 0, seen_, to);
    traverse_near(tree_, point_, nearest);
    to.resize(nearest.found().size());
  }

  /// Replace `to` by all primitives within the radius, in their order.
  void within(std::vector<Neighbour>& to) const {
    to.clear();
    WithinOfPoint within(point_, 0, seen_, PointSearch<P>::kRepeats, to);
    traverse_near(tree_, point_, within);
    within.finish();
  }

  std::size_t count_within() const {
    if (PointSearch<P>::kRepeats || seen_.has_owners()) {
      std::vector<Neighbour> list;
      within(list);
      return list.size();
    }
    CountOfPoint count(point_, 0, seen_);
    traverse_near(tree_, point_, count);
    return count.n;
  }

 private:
  const WideBvhView<P>& tree_;
  const PointQuery point_;
  const Seen seen_;
};

}  // namespace fastlines
