// Points, the lines near them, and pairs of lines near each other. They are plain data.
#pragma once

#include "ray.hpp"

namespace fl {

/// What the distance to a line is to. It makes no difference for lines without a radius.
enum class To {
  surface,  ///< To the surface. It is negative inside, where the deepest line is the nearest one.
  axis,     ///< To the axis.
};

/// A point, in double and in the caller's coordinates: queries subtract `Tree::offset` from it.
struct Point {
  Vec3d position;  ///< Its coordinates.
  /// The lines that queries leave out, as if they were not there; −1 names none. The numbers are not copied.
  std::span<const std::int64_t> ignore = std::span<const std::int64_t>();
  /// The strands that queries leave out. Lines without a strand stay.
  std::span<const std::int64_t> ignore_strands = std::span<const std::int64_t>();

  /// Makes the point 0 0 0.
  Point() = default;
  /// Makes a point.
  Point(const Vec3d& position_) : position(position_) {}
  /// Makes a point from its coordinates.
  Point(double x, double y, double z) : position(Vec3d{x, y, z}) {}
};

/// One number for all points of a batch, or one for each.
using PerPoint = PerRay;

/// A batch of points. Its array belongs to the caller and is not copied.
struct Points {
  std::span<const Vec3d> positions;  ///< Their coordinates.
  /// The lines that queries leave out for all points.
  std::span<const std::int64_t> ignore = std::span<const std::int64_t>();
  /// The strands that queries leave out for all points.
  std::span<const std::int64_t> ignore_strands = std::span<const std::int64_t>();

  /// Returns the number of points.
  std::size_t size() const { return positions.size(); }
  /// Returns point i.
  Point operator[](std::size_t i) const {
    Point point(positions[i]);
    point.ignore = ignore;
    point.ignore_strands = ignore_strands;
    return point;
  }
};

/// A line near a point, or none. A new `NearLine` is none.
struct NearLine {
  float distance = infinity;  ///< The distance of the line from the point, to its axis or to its surface.
  std::int64_t prim = -1;     ///< The index of the line, or −1 for none.
  float u = 0;                ///< The place on the line that is nearest: 0 at p, 1 at q.

  /// Returns whether there is a line.
  explicit operator bool() const { return prim >= 0; }
};

/// Lines near points, as one array for each member of `NearLine`. Copies share the arrays.
struct NearLines {
  std::span<const float> distance;     ///< The distances of the lines from the points.
  std::span<const std::int64_t> prim;  ///< The indices of the lines; −1 for none.
  std::span<const float> u;            ///< The places on the lines.
  std::shared_ptr<const void> owner;   ///< It keeps the arrays alive.

  /// Returns the number of entries.
  std::size_t size() const { return distance.size(); }
  /// Returns entry i.
  NearLine operator[](std::size_t i) const { return {distance[i], prim[i], u[i]}; }
  /// Returns the entries from `begin` up to `end`, without `end`.
  NearLines slice(std::size_t begin, std::size_t end) const {
    const std::size_t n = end - begin;
    return {distance.subspan(begin, n), prim.subspan(begin, n), u.subspan(begin, n), owner};
  }
};

/// The lines within a radius of many points. Those of a point are sorted by their distance. Copies share the arrays.
struct NearLists {
  std::span<const std::int64_t> offsets;  ///< Those of point i are from `offsets[i]` up to `offsets[i + 1]`.
  NearLines lines;                        ///< The lines of all points, one point after the other.
  std::shared_ptr<const void> owner;      ///< It keeps the offsets alive.

  /// Returns the number of points.
  std::size_t n_points() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  /// Returns the lines of point i.
  NearLines operator[](std::size_t i) const {
    return lines.slice(std::size_t(offsets[i]), std::size_t(offsets[i + 1]));
  }
};

/// Two lines near each other.
struct Pair {
  std::int64_t i, j;  ///< The indices of the lines. In pairs of one tree, i < j.
  float s, t;         ///< The places where they are nearest: s on line i, t on line j.
  float distance;     ///< How far these places are from each other; less both radii there with `To::surface`.
};

/// Pairs, as one array for each member of `Pair`, sorted by i and then by j. Copies share the arrays.
struct Pairs {
  std::span<const std::int64_t> i, j;  ///< The indices of the lines.
  std::span<const float> s, t;         ///< The places where they are nearest.
  std::span<const float> distance;     ///< Their distances.
  std::shared_ptr<const void> owner;   ///< It keeps the arrays alive.

  /// Returns the number of pairs.
  std::size_t size() const { return i.size(); }
  /// Returns a pair.
  Pair operator[](std::size_t pair) const { return {i[pair], j[pair], s[pair], t[pair], distance[pair]}; }
};

}  // namespace fl
