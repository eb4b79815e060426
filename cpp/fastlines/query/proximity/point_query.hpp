// A point, prepared for a scene's frame.
#pragma once

#include <limits>
#include <span>

#include "../../primitives/point_test.hpp"
#include "../../rays/frame.hpp"

namespace fastlines {

/// A point of a query, in the frame.
struct PointQuery {
  Vec3 p;
  float radius, radius2;  ///< what is farther is not reported; radius2 = radius²
  float eps;              ///< covers the rounding of the exact test, of culling, and of the boxes
  bool surface;           ///< whether the radii of round cones count
};
static_assert(PointView<PointQuery>);

/// Prepare a point. It is rounded once, from float64: nothing of it is lost where a scene is far from zero.
inline PointQuery prepare_point(const double* point, float radius, bool surface, const Frame& frame) {
  constexpr float most = std::numeric_limits<float>::max();
  PointQuery query;
  float largest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    query.p[k] = float((point[k] - double(frame.centre[k])) * double(frame.scale));
    largest = max(largest, std::fabs(query.p[k]));
  }
  query.radius = min(radius * frame.scale, most);
  query.radius2 = min(query.radius * query.radius, most);
  query.eps = (3.0f + largest) * 0x1p-19f + frame.overhang;
  query.surface = surface;
  return query;
}

/// Points as an array of three coordinates each, and their radii: one for each point, or one for all.
struct PointBatch {
  std::span<const double> coordinates;
  std::span<const float> radius;
  bool surface;

  std::size_t size() const { return coordinates.size() / 3; }
  PointQuery prepare(std::size_t i, const Frame& frame) const {
    return prepare_point(coordinates.data() + 3 * i, radius[radius.size() == 1 ? 0 : i], surface, frame);
  }
};

}  // namespace fastlines
