// Where hits are, in double, with the bits that Python's hits have.
#include "place.hpp"

#include <algorithm>
#include <cmath>

#include "fastlines/query/round_cone_entry.hpp"

namespace fl::detail {
namespace {

using Vector = fastlines::Vector3<double>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// How far outside a surface `outside` is, as a fraction of the scene's size and the radius together.
constexpr double kOutside = 0x1p-20;

Vector in_double(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3d to_point(const Vector& v) { return {v.x, v.y, v.z}; }

/// A vector across one of length one, and any for NaN: as `perpendicular` in Python's geometry/hit_places.py.
Vector across(const Vector& v) {
  if (std::isnan(v.x)) return across({0, 0, 1});
  const double x = std::fabs(v.x), y = std::fabs(v.y), z = std::fabs(v.z);
  const Vector least = x <= y && x <= z ? Vector{1, 0, 0} : y <= z ? Vector{0, 1, 0} : Vector{0, 0, 1};
  return cross(v, least);
}

}  // namespace

Place place_of(const RoundCone& line, const Ray& ray, float radius, const Hit& hit, double scene_size) {
  const Vector origin = in_double(ray.origin), direction = in_double(ray.direction);
  const fastlines::RoundConeInDouble<double> cone{in_double(line.p), in_double(line.q) - in_double(line.p),
                                                  double(line.radius_p) + radius,
                                                  (double(line.radius_q) + radius) - (double(line.radius_p) + radius)};
  const bool is_surface = std::isfinite(hit.t_out);
  double t = hit.t, s = hit.u;
  // Intersect the surface, except where a bound of the ray cut it off.
  if (is_surface && hit.t != ray.t_min && hit.t != ray.t_max)
    if (const auto entry = enter(cone, origin, direction); std::isfinite(entry.t)) {
      t = entry.t;
      s = entry.s;
    }
  const Vector point = origin + t * direction;
  const Vec3d tangent = to_point(unit(cone.edge)), none{kNan, kNan, kNan};
  if (!is_surface) return {to_point(point), none, tangent, none};
  const Vector away = point - (cone.start + s * cone.edge), normal = unit(is_zero(away) ? -direction : away);
  const double distance = kOutside * (scene_size + std::fmax(line.radius_p, line.radius_q) + radius);
  return {to_point(point), to_point(normal), tangent, to_point(point + distance * normal)};
}

Vec3d place_near(const RoundCone& line, const Vec3d& point, double u, bool surface) {
  const Vector start = in_double(line.p), edge = in_double(line.q) - start, axis = start + u * edge;
  if (!surface) return to_point(axis);
  Vector away = Vector{point.x, point.y, point.z} - axis;
  if (is_zero(away)) away = across(unit(edge));
  return to_point(axis + ((1 - u) * line.radius_p + u * line.radius_q) * unit(away));
}

Place place_of_miss() {
  constexpr Vec3d none{kNan, kNan, kNan};
  return {none, none, none, none};
}

}  // namespace fl::detail
