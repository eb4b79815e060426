// Where a hit is, in double.
#pragma once

#include "fastlines/api/ray.hpp"

namespace fl::detail {

/// The place of a hit of a line by a ray. `scene_size` is that of `TreeImpl`.
Place place_of(const RoundCone& line, const Ray& ray, float radius, const Hit& hit, double scene_size);

/// The place of a miss.
Place place_of_miss();

}  // namespace fl::detail
