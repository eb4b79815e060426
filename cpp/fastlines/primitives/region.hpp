// A region of interest: an axis-parallel box in float64, and the exact tests of what is in it.
//
// A region is closed, so what touches a side is in it, and sides may be infinite. The tests compute in float64 from the
// float32 coordinates of primitives, without contraction, so their bits are the same everywhere.
//
// - The part of a segment between two planes is an interval of s. The segment is in the region if the three intervals
//   share an s. Division is rounded correctly: where differences of coordinates are exact in float64, a segment that
//   touches an edge of the region has equal bounds, and is in it.
// - With the distance D(s) of the axis from the region and the radius R(s), a round cone is in the region if
//   D(s)² ≤ R(s)² for some s. D² − R² is a quadratic between the s at which the axis crosses planes of the sides. So it
//   is least at one of these, at an end, or at the vertex of a quadratic.
// - A triangle is in the region if an edge is, or if no axis separates the two (Akenine-Möller, "Fast 3D Triangle-Box
//   Overlap Testing", 2001).
#pragma once

#include <algorithm>
#include <utility>

#include "shapes.hpp"

namespace fastlines {

struct Region {
  double lo[3], hi[3];

  bool has(const Box& box) const {
    for (int k = 0; k < 3; ++k)
      if (box.hi[k] < lo[k] || box.lo[k] > hi[k]) return false;
    return true;
  }

  bool has(const Segment& segment) const {
    double s0 = 0.0, s1 = 1.0;
    for (int k = 0; k < 3; ++k) {
      const double p = segment.p[k], q = segment.q[k], e = q - p;
      if (std::max(p, q) < lo[k] || std::min(p, q) > hi[k]) return false;
      if (e == 0.0) continue;
      const double at_lo = (lo[k] - p) / e, at_hi = (hi[k] - p) / e;
      s0 = std::max(s0, std::min(at_lo, at_hi));
      s1 = std::min(s1, std::max(at_lo, at_hi));
    }
    return s0 <= s1;
  }

  bool has(const RoundCone& cone) const {
    if (has(cone.axis)) return true;
    if (!(RoundCones::radius(cone) > 0.0f)) return false;

    // List the s at which the axis crosses planes, in order.
    const Axis axis(cone);
    double s[8] = {0.0, 1.0};
    int n = 2;
    for (int k = 0; k < 3; ++k)
      for (const double plane : {lo[k], hi[k]}) {
        const double at = (plane - axis.p[k]) / axis.e[k];
        if (!(at > 0.0 && at < 1.0)) continue;
        int i = n++;
        for (; s[i - 1] > at; --i) s[i] = s[i - 1];
        s[i] = at;
      }
    for (int i = 0; i < n; ++i)
      if (has_ball(axis, s[i])) return true;

    // Between two of them, D² − R² = a·s² + 2b·s + c.
    for (int i = 0; i + 1 < n; ++i) {
      const double middle = 0.5 * (s[i] + s[i + 1]);
      double a = -axis.m * axis.m, b = -axis.m * axis.radius0;
      for (int k = 0; k < 3; ++k) {
        const double x = axis.point(middle, k);
        if (x >= lo[k] && x <= hi[k]) continue;
        a += axis.e[k] * axis.e[k];
        b += axis.e[k] * (axis.p[k] - (x < lo[k] ? lo[k] : hi[k]));
      }
      if (a > 0.0 && has_ball(axis, std::clamp(-b / a, s[i], s[i + 1]))) return true;
    }
    return false;
  }

  bool has(const Triangle& triangle) const {
    const auto& corner = triangle.corner;
    for (int i = 0; i < 3; ++i)
      if (has(Segment{corner[i], corner[(i + 1) % 3]})) return true;

    // Cut the region to the box of the triangle, so that no side is infinite.
    const Box bounds = triangle.bounds();
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = std::max(lo[k], double(bounds.lo[k]));
      high[k] = std::min(hi[k], double(bounds.hi[k]));
      if (low[k] > high[k]) return false;
    }

    // Try the axes perpendicular to an edge and to a side. Places are relative to the start of the edge.
    double edge[3][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) edge[i][k] = double(corner[(i + 1) % 3][k]) - corner[i][k];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        double normal[3] = {};
        normal[(k + 1) % 3] = -edge[i][(k + 2) % 3];
        normal[(k + 2) % 3] = edge[i][(k + 1) % 3];
        double third = 0.0;
        for (int j = 0; j < 3; ++j) third += normal[j] * (double(corner[(i + 2) % 3][j]) - corner[i][j]);
        const auto [least, most] = extent(low, high, corner[i], normal);
        if (least > std::max(0.0, third) || most < std::min(0.0, third)) return false;
      }

    // Try the normal of the triangle.
    double normal[3];
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      normal[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
    }
    const auto [least, most] = extent(low, high, corner[0], normal);
    return least <= 0.0 && most >= 0.0;
  }

 private:
  /// The axis of a round cone and its radius at s, radius0 + s·m.
  struct Axis {
    double p[3], q[3], e[3], radius0, radius1, m;

    explicit Axis(const RoundCone& cone) : radius0(cone.radius0), radius1(cone.radius1), m(radius1 - radius0) {
      for (int k = 0; k < 3; ++k) {
        p[k] = cone.axis.p[k];
        q[k] = cone.axis.q[k];
        e[k] = q[k] - p[k];
      }
    }
    double point(double s, int k) const { return s == 1.0 ? q[k] : p[k] + s * e[k]; }
    double radius(double s) const { return s == 1.0 ? radius1 : radius0 + s * m; }
  };

  /// Whether the ball around the point at s is in the region; not if s is NaN.
  bool has_ball(const Axis& axis, double s) const {
    double distance2 = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double x = axis.point(s, k), d = x < lo[k] ? lo[k] - x : x > hi[k] ? x - hi[k] : 0.0;
      distance2 += d * d;
    }
    const double radius = axis.radius(s);
    return distance2 <= radius * radius;
  }

  /// The least and the largest product of `normal` with a point of a box, relative to `origin`.
  static std::pair<double, double> extent(const double (&low)[3], const double (&high)[3], const Vec3& origin,
                                          const double (&normal)[3]) {
    double least = 0.0, most = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double at_low = normal[k] * (low[k] - origin[k]), at_high = normal[k] * (high[k] - origin[k]);
      least += std::min(at_low, at_high);
      most += std::max(at_low, at_high);
    }
    return {least, most};
  }
};
static_assert(sizeof(Region) == 48);

/// Whether a primitive is in a region: a round cone as a whole, with its surface, or its axis alone.
inline bool is_in(const Region& region, const Segment& segment, bool) { return region.has(segment); }
inline bool is_in(const Region& region, const RoundCone& cone, bool surface) {
  return surface ? region.has(cone) : region.has(cone.axis);
}
inline bool is_in(const Region& region, const Shape& shape, bool surface) {
  switch (shape.kind()) {
    case Shape::round_cone:
      return is_in(region, shape.as<RoundCone>(), surface);
    case Shape::triangle:
      return region.has(shape.as<Triangle>());
    default:
      return region.has(shape.as<Box>());
  }
}

}  // namespace fastlines
