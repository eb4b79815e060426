// A triangle, and its part in a box, by cutting the polygon at the box's six planes (Sutherland, Hodgman 1974).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "../math/box.hpp"

namespace fastlines {

struct Triangle {
  std::array<Vec3, 3> corner;

  Box bounds() const {
    Box box = Box::empty();
    for (const Vec3& point : corner) box.grow(point);
    return box;
  }

  /// The box of the part in `box`; empty if there is none.
  Box clipped_bounds(const Box& box) const {
    using Point = std::array<double, 3>;
    std::array<Point, 9> polygon{}, kept{};
    int n = 3;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) polygon[i][k] = corner[i][k];

    // Keep the part on the inner side of each plane.
    for (int k = 0; k < 3; ++k)
      for (const double sign : {1.0, -1.0}) {
        const double plane = sign > 0 ? box.hi[k] : box.lo[k];
        int n_kept = 0;
        for (int i = 0; i < n; ++i) {
          const Point &a = polygon[i], &b = polygon[(i + 1) % n];
          const double beyond_a = sign * (a[k] - plane), beyond_b = sign * (b[k] - plane);
          if (beyond_a <= 0) kept[n_kept++] = a;
          if ((beyond_a < 0 && beyond_b > 0) || (beyond_a > 0 && beyond_b < 0)) {
            const double s = beyond_a / (beyond_a - beyond_b);
            for (int j = 0; j < 3; ++j) kept[n_kept][j] = a[j] + s * (b[j] - a[j]);
            kept[n_kept++][k] = plane;
          }
        }
        std::swap(polygon, kept);
        n = n_kept;
      }

    // Round outwards, but never beyond the box.
    Box clipped = Box::empty();
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) {
        const float at = float(polygon[i][k]);
        const float below = at > polygon[i][k] ? std::nextafter(at, -HUGE_VALF) : at;
        const float above = at < polygon[i][k] ? std::nextafter(at, HUGE_VALF) : at;
        clipped.lo[k] = std::min(clipped.lo[k], std::max(below, box.lo[k]));
        clipped.hi[k] = std::max(clipped.hi[k], std::min(above, box.hi[k]));
      }
    return clipped;
  }
};
static_assert(sizeof(Triangle) == 36);

}  // namespace fastlines
