// Rays, lines and hits of the library. They are plain data; all coordinates are in units of the scene.
#pragma once

#ifndef __cpp_concepts
#error "fastlines needs C++20 or later: compile with -std=c++20 or -std=c++23"
#endif

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace fl {

/// The t of a ray without an end, and of a miss.
inline constexpr float infinity = std::numeric_limits<float>::infinity();

/// A point or a direction.
struct Vec3 {
  float x = 0, y = 0, z = 0;  ///< The coordinates.
};

/// A point or a direction in double.
struct Vec3d {
  double x = 0, y = 0, z = 0;  ///< The coordinates.
};

/// A line from p to q. The radius of a query says how near a ray must come to hit it.
struct Segment {
  Vec3 p, q;  ///< The ends.
};

/// A line with a radius at each end. The radius is linear in between, and the radius of a query adds to it.
struct RoundCone {
  Vec3 p, q;                         ///< The ends.
  float radius_p = 0, radius_q = 0;  ///< The radius at each end.
};

/// The points `origin` + t·`direction` with `t_min` ≤ t ≤ `t_max`. Rays with a spread, or that leave lines out, are
/// traced by a slower kernel.
struct Ray {
  Vec3 origin;                        ///< Where t is 0.
  Vec3 direction;                     ///< It need not have length 1, but it must not be zero.
  float t_min = 0, t_max = infinity;  ///< The ends of the ray. `t_min` must be below infinity.
  float spread = 0;  ///< By how much the radius of the query grows for each unit of length along the ray.
  /// The lines that queries leave out, as if they were not there; −1 names none. The numbers are not copied.
  std::span<const std::int64_t> ignore = std::span<const std::int64_t>();
  /// The strands that queries leave out. Lines without a strand stay.
  std::span<const std::int64_t> ignore_strands = std::span<const std::int64_t>();

  /// Makes a ray whose direction has yet to be set.
  Ray() = default;
  /// Makes a ray, by default one without an end.
  Ray(Vec3 origin_, Vec3 direction_, float t_min_ = 0, float t_max_ = infinity)
      : origin(origin_), direction(direction_), t_min(t_min_), t_max(t_max_) {}
};

/// What the hits of a ray are ranked by.
enum class Rank {
  t,         ///< Their place on the ray.
  distance,  ///< The distance of the line from the ray, and then t.
};

/// The place on the ray that t of a hit means, and which rays hit.
enum class At {
  closest,  ///< Where the ray comes closest to the line.
  surface,  ///< Where the ray enters the surface around the line.
  entry,    ///< The same, and only rays that enter hit: those that start inside, or on the surface, do not.
};

/// A hit, or a miss. A new `Hit` is a miss.
struct Hit {
  float t = infinity;         ///< The place on the ray, in units of the length of its direction.
  std::int64_t prim = -1;     ///< The index of the line, or −1 for a miss.
  float u = 0;                ///< The place on the line: 0 at p, 1 at q.
  float distance = infinity;  ///< The distance of the ray from the line, at the closest approach.
  float t_out = infinity;     ///< Where the ray leaves the surface; infinite with `At::closest`.

  /// Returns whether this is a hit.
  explicit operator bool() const { return prim >= 0; }
};

/// Where a hit is. All members of a miss are NaN.
struct Place {
  /// The point of the ray at t. On the surface, it is computed in double.
  Vec3d point;
  /// The unit normal of the surface there, outwards; NaN with `At::closest`. For a ray that starts inside,
  /// it is the direction from the point of the axis at u, or opposite to the ray if that is the point itself.
  Vec3d normal;
  Vec3d tangent;  ///< The unit vector from p to q. It is NaN for a line of length zero.
  /// The point, moved along the normal: a ray that starts here and leaves the surface does not hit it again.
  Vec3d outside;
};

/// One number for all rays of a batch, or one for each.
class PerRay {
 public:
  /// Gives one number to all rays.
  PerRay(float for_all) : for_all_(for_all) {}
  /// Gives a number to each ray. The array is not copied.
  PerRay(std::span<const float> each) : each_(each), is_each_(true) {}
  /// Gives a number to each ray. The vector is not copied, so it must outlive the query.
  PerRay(const std::vector<float>& each) : PerRay(std::span<const float>(each)) {}

  /// Returns the numbers: one, or as many as there are rays.
  std::span<const float> values() const { return is_each_ ? each_ : std::span<const float>(&for_all_, 1); }
  /// Returns the number of ray i.
  float operator[](std::size_t i) const { return is_each_ && each_.size() > 1 ? each_[i] : values()[0]; }

 private:
  float for_all_ = 0;
  std::span<const float> each_;
  bool is_each_ = false;
};

/// A batch of rays. Its arrays belong to the caller and are not copied.
struct Rays {
  std::span<const Vec3> origins, directions;  ///< Both are of the same length.
  PerRay t_min = 0.0f, t_max = infinity;      ///< The ends of the rays.
  PerRay spread = 0.0f;                       ///< By how much radii grow for each unit of length along the rays.
  /// The lines that all rays leave out.
  std::span<const std::int64_t> ignore = std::span<const std::int64_t>();
  /// The strands that all rays leave out.
  std::span<const std::int64_t> ignore_strands = std::span<const std::int64_t>();

  /// Returns the number of rays.
  std::size_t size() const { return origins.size(); }
  /// Returns ray i.
  Ray operator[](std::size_t i) const {
    Ray ray(origins[i], directions[i], t_min[i], t_max[i]);
    ray.spread = spread[i];
    ray.ignore = ignore;
    ray.ignore_strands = ignore_strands;
    return ray;
  }
};

/// Hits, as one array for each member of `Hit`. Copies share the arrays.
struct Hits {
  std::span<const float> t;            ///< The places on the rays.
  std::span<const std::int64_t> prim;  ///< The indices of the lines. Misses have −1.
  std::span<const float> u, distance;  ///< The places on the lines, and their distances from the rays.
  std::span<const float> t_out;        ///< Where the rays leave the surfaces. It is empty with `At::closest`.
  std::shared_ptr<const void> owner;   ///< It keeps the arrays alive.

  /// Returns the number of hits and misses.
  std::size_t size() const { return t.size(); }
  /// Returns hit i.
  Hit operator[](std::size_t i) const {
    return {t[i], prim[i], u[i], distance[i], t_out.empty() ? infinity : t_out[i]};
  }
  /// Returns the hits from `begin` up to `end`, without `end`.
  Hits slice(std::size_t begin, std::size_t end) const {
    const auto part = [=](auto column) { return column.empty() ? column : column.subspan(begin, end - begin); };
    return {part(t), part(prim), part(u), part(distance), part(t_out), owner};
  }
};

/// The hits of many rays. Those of a ray are sorted by t. Copies share the arrays.
struct HitLists {
  std::span<const std::int64_t> offsets;  ///< The hits of ray i are those from `offsets[i]` up to `offsets[i + 1]`.
  Hits hits;                              ///< The hits of all rays, one ray after the other.
  std::shared_ptr<const void> owner;      ///< It keeps the offsets alive.

  /// Returns the number of rays.
  std::size_t n_rays() const { return offsets.empty() ? 0 : offsets.size() - 1; }
  /// Returns the hits of ray i.
  Hits operator[](std::size_t i) const { return hits.slice(std::size_t(offsets[i]), std::size_t(offsets[i + 1])); }
};

}  // namespace fl
