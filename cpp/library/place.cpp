// Where a ray enters a round cone, in double: the formulas of fastlines/primitives/round_cone_test.hpp, in the order of
// Python's geometry/round_cone_entry.py, so that both give the same bits.
#include "place.hpp"

#include <cmath>

namespace fl::detail {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// How far outside a surface `outside` is, as a fraction of the scene's size and the radius together.
constexpr double kOutside = 0x1p-20;

Vec3d in_double(const Vec3& v) { return {v.x, v.y, v.z}; }
Vec3d operator+(const Vec3d& a, const Vec3d& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3d operator-(const Vec3d& a, const Vec3d& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3d operator*(double s, const Vec3d& v) { return {s * v.x, s * v.y, s * v.z}; }
double dot(const Vec3d& a, const Vec3d& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// The vector at length one, without negative zeros; NaN for one of length zero.
Vec3d unit(const Vec3d& v) {
  const double length = std::sqrt(dot(v, v));
  return {v.x / length + 0.0, v.y / length + 0.0, v.z / length + 0.0};
}

/// A round cone in double: its radius is radius + s·slope at start + s·edge.
struct Cone {
  Vec3d start, edge;
  double radius, slope;
};

/// Where a line enters a round cone: t in units of the direction's length, and s of the ball that it touches there.
struct Entry {
  double t, s;
};

/// The entry of a line that hits the cone; t is NaN if rounding makes the line miss.
Entry enter(const Cone& cone, const Vec3d& origin, const Vec3d& direction) {
  const double length = std::sqrt(dot(direction, direction));
  const Vec3d ray{direction.x / length, direction.y / length, direction.z / length};
  // Measure depths from the point of the line that is nearest to the middle of the axis, so that nothing cancels.
  const double shift = dot(cone.start + 0.5 * cone.edge - origin, ray);
  const Vec3d offset = cone.start - origin - shift * ray;
  const double p_r = dot(offset, ray), e_r = dot(cone.edge, ray);
  const Vec3d a = offset - p_r * ray, b = cone.edge - e_r * ray;
  const double slope2 = cone.slope * cone.slope, e2 = dot(cone.edge, cone.edge);
  // Q(s) = c0 + 2·c1·s + c2·s², the squared half chord in the ball at s.
  const double c0 = cone.radius * cone.radius - dot(a, a), c1 = cone.radius * cone.slope - dot(a, b);
  const double c2 = slope2 - dot(b, b);
  const double k = std::sqrt((c1 * c1 - c0 * c2) / (e2 - slope2)), w = e_r * k;
  const double s = w * c1 > 0 ? (c1 * c1 - e_r * e_r * c0) / ((e2 - slope2) * (w + c1)) : (w - c1) / c2;
  const double t = p_r + s * e_r - std::sqrt(c0 + s * (2 * c1 + s * c2));
  if (s >= 0 && s <= 1 && e2 > slope2 && std::isfinite(t)) return {(t + shift) / length, s};
  const double t0 = p_r - std::sqrt(c0), t1 = p_r + e_r - std::sqrt(c0 + 2 * c1 + c2);
  return {(std::fmin(t0, t1) + shift) / length, std::isnan(t0) || t1 < t0 ? 1.0 : 0.0};
}

}  // namespace

Place place_of(const RoundCone& line, const Ray& ray, float radius, const Hit& hit, double scene_size) {
  const Vec3d origin = in_double(ray.origin), direction = in_double(ray.direction);
  const Cone cone{in_double(line.p), in_double(line.q) - in_double(line.p), double(line.radius_p) + radius,
                  (double(line.radius_q) + radius) - (double(line.radius_p) + radius)};
  const bool is_surface = std::isfinite(hit.t_out);
  double t = hit.t, s = hit.u;
  // Intersect the surface, except where a bound of the ray cut it off.
  if (is_surface && hit.t != ray.t_min && hit.t != ray.t_max)
    if (const Entry entry = enter(cone, origin, direction); std::isfinite(entry.t)) {
      t = entry.t;
      s = entry.s;
    }
  const Vec3d point = origin + t * direction, tangent = unit(cone.edge), none{kNan, kNan, kNan};
  if (!is_surface) return {point, none, tangent, none};
  const Vec3d away = point - (cone.start + s * cone.edge);
  const bool is_centre = away.x == 0 && away.y == 0 && away.z == 0;
  const Vec3d normal = unit(is_centre ? -1.0 * direction : away);
  const double distance = kOutside * (scene_size + std::fmax(line.radius_p, line.radius_q) + radius);
  return {point, normal, tangent, point + distance * normal};
}

Place place_of_miss() {
  constexpr Vec3d none{kNan, kNan, kNan};
  return {none, none, none, none};
}

}  // namespace fl::detail
