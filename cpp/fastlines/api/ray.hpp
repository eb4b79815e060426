// Rays, lines and hits of the library. They are plain data; all coordinates are in units of the scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace fl {

inline constexpr float infinity = std::numeric_limits<float>::infinity();

struct Vec3 {
  float x = 0, y = 0, z = 0;
};

/// A line from p to q. A query's radius decides how near a ray must come to hit it.
struct Segment {
  Vec3 p, q;
};

/// A line with a radius at each end, linear in between. The radius of a query adds to it.
struct RoundCone {
  Vec3 p, q;
  float radius_p = 0, radius_q = 0;
};

/// The points origin + t·direction, t_min ≤ t ≤ t_max. The direction need not have length 1.
struct Ray {
  Vec3 origin, direction;
  float t_min = 0, t_max = infinity;

  Ray() = default;
  Ray(Vec3 origin_, Vec3 direction_, float t_min_ = 0, float t_max_ = infinity)
      : origin(origin_), direction(direction_), t_min(t_min_), t_max(t_max_) {}
};

/// Where t is taken: where the ray comes closest to the line, or where it enters the surface around it.
enum class At { closest, surface };

/// A hit, or a miss by default. `if (hit)` asks which.
struct Hit {
  float t = infinity;         ///< along the ray, in units of its direction
  std::int64_t prim = -1;     ///< the index of the line; −1 for a miss
  float u = 0;                ///< where on the line: 0 at p, 1 at q
  float distance = infinity;  ///< from the ray to the line, at the closest approach
  float t_out = infinity;     ///< where the ray leaves the surface; only with At::surface

  explicit operator bool() const { return prim >= 0; }
};

/// One number for each ray of a batch, or one for all.
class PerRay {
 public:
  PerRay(float for_all) : for_all_(for_all) {}
  PerRay(std::span<const float> each) : each_(each), is_each_(true) {}

  /// The numbers: one, or as many as there are rays.
  std::span<const float> values() const { return is_each_ ? each_ : std::span<const float>(&for_all_, 1); }

 private:
  float for_all_ = 0;
  std::span<const float> each_;
  bool is_each_ = false;
};

/// A batch of rays. The arrays are the caller's, and are not copied.
struct Rays {
  std::span<const Vec3> origins, directions;
  PerRay t_min = 0.0f, t_max = infinity;

  std::size_t size() const { return origins.size(); }
};

/// Hits as one array for each property. Copies share the arrays.
struct Hits {
  std::span<const float> t;
  std::span<const std::int64_t> prim;
  std::span<const float> u, distance;
  std::span<const float> t_out;       ///< empty with At::closest
  std::shared_ptr<const void> owner;  ///< keeps the arrays

  std::size_t size() const { return t.size(); }
  Hit operator[](std::size_t i) const {
    return {t[i], prim[i], u[i], distance[i], t_out.empty() ? infinity : t_out[i]};
  }
  /// Hits [begin, end).
  Hits slice(std::size_t begin, std::size_t end) const {
    const auto part = [=](auto column) { return column.empty() ? column : column.subspan(begin, end - begin); };
    return {part(t), part(prim), part(u), part(distance), part(t_out), owner};
  }
};

/// Hits of many rays, sorted: those of ray i are offsets[i] up to offsets[i + 1]. Copies share the arrays.
struct HitLists {
  std::span<const std::int64_t> offsets;
  Hits hits;
  std::shared_ptr<const void> owner;  ///< keeps the offsets

  std::size_t n_rays() const { return offsets.size() - 1; }
  /// The hits of ray i.
  Hits operator[](std::size_t i) const { return hits.slice(std::size_t(offsets[i]), std::size_t(offsets[i + 1])); }
};

}  // namespace fl
