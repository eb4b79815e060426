// Where a hit is, and the nearest point of a line, in double.
#pragma once

#include "fastlines/api/ray.hpp"

namespace fl::detail {

/// The place of a hit of a line by a ray. `scene_size` is that of `TreeImpl`.
Place place_of(const RoundCone& line, const Ray& ray, float radius, const Hit& hit, double scene_size);

/// The point of a line at u, or that of its surface in the direction of `point`.
Vec3d place_near(const RoundCone& line, const Vec3d& point, double u, bool surface);

/// The place of a miss.
Place place_of_miss();

}  // namespace fl::detail
