// Where a ray enters a round cone, in double: the formulas of fastlines/primitives/round_cone_test.hpp, in the order of
// Python's geometry/round_cone_entry.py, so that both give the same bits.
#include "place.hpp"

#include <algorithm>
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

Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The vector at length one, without negative zeros; NaN for one of length zero.
Vec3d unit(const Vec3d& v) {
  const double length = std::sqrt(dot(v, v));
  return {v.x / length + 0.0, v.y / length + 0.0, v.z / length + 0.0};
}

/// A vector across one of length one, and any for NaN: as `perpendicular` in Python's geometry/hit_places.py.
Vec3d across(const Vec3d& v) {
  if (std::isnan(v.x)) return across({0, 0, 1});
  const double x = std::fabs(v.x), y = std::fabs(v.y), z = std::fabs(v.z);
  const Vec3d least = x <= y && x <= z ? Vec3d{1, 0, 0} : y <= z ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  return cross(v, least);
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
  const double b2 = dot(b, b), m2 = cone.slope * cone.slope, c2 = m2 - b2, length2 = e_r * e_r - c2;
  const bool is_steep = c2 >= 0;
  const double larger_end = cone.slope > 0 ? 1.0 : 0.0, smaller_end = 1.0 - larger_end;
  // The centre of the ball at s across the ray, its radius, Q(s), and half the derivative of Q there.
  struct Ball {
    Vec3d x;
    double reach, c0, c1;
  };
  const auto ball_at = [&](double s) {
    const Vec3d x = a + s * b;
    const double reach = cone.radius + s * cone.slope;
    return Ball{x, reach, reach * reach - dot(x, x), reach * cone.slope - dot(x, b)};
  };
  // The line hits if the largest Q, the squared half chord in the ball at s, is 0 or more.
  const double inmost = is_steep ? larger_end : std::clamp((dot(a, b) - cone.radius * cone.slope) / c2, 0.0, 1.0);
  const Ball near = ball_at(inmost);
  if (!(near.c0 >= 0)) return {kNan, kNan};
  // Expand Q where the radius is least, and find the ball that the line touches.
  const double from = b2 < 2 * m2 ? smaller_end : inmost;
  const auto [x, reach, c0, c1] = ball_at(from);
  const Vec3d g = cone.slope * x - reach * b;
  const double h = dot(cross(x, b), ray),
               discriminant = is_steep ? dot(g, g) - h * h : near.c1 * near.c1 - near.c0 * c2;
  const double w = e_r * std::sqrt((discriminant < 0 ? 0.0 : discriminant) / length2);
  const double step = w * c1 > 0 ? (c1 * c1 - e_r * e_r * c0) / (length2 * (w + c1)) : (w - c1) / c2;
  const double touched = std::isnan(from + step) ? 0.0 : std::clamp(from + step, 0.0, 1.0);
  const double end = cone.slope != 0 ? larger_end : e_r < 0 ? 1.0 : 0.0;
  const double s = is_steep && (e_r * cone.slope <= 0 || length2 <= 0) ? end : touched;
  const double half_chord2 = ball_at(s).c0;
  return {(p_r + s * e_r - std::sqrt(half_chord2 < 0 ? 0.0 : half_chord2) + shift) / length, s};
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

Vec3d place_near(const RoundCone& line, const Vec3d& point, double u, bool surface) {
  const Vec3d start = in_double(line.p), edge = in_double(line.q) - start, axis = start + u * edge;
  if (!surface) return axis;
  Vec3d away = point - axis;
  if (away.x == 0 && away.y == 0 && away.z == 0) away = across(unit(edge));
  return axis + ((1 - u) * line.radius_p + u * line.radius_q) * unit(away);
}

Place place_of_miss() {
  constexpr Vec3d none{kNan, kNan, kNan};
  return {none, none, none, none};
}

}  // namespace fl::detail
