// Distant lights, the sky, and directions that are drawn around a normal. fastlines.rendering.shading.lighting defines
// them; it gives the rows, in the frame of the scene.
#pragma once

#include "../simd/functions.hpp"

namespace fastlines {

/// A distant light: the direction to the centre of its disc, two radii of the disc, and its irradiance.
struct DistantLight {
  float towards[3], radius[3], other_radius[3], color[3];

  /// Unit vectors towards points of the disc, one for each pair of uniform numbers.
  Vec3Lanes sample(const FloatLanes& first, const FloatLanes& second) const {
    const FloatLanes away = sqrt(first);
    const SinCos turn = sincos(2.0f * kPi * second);
    return unit(Vec3Lanes::of(towards) + (away * turn.cos) * Vec3Lanes::of(radius) +
                (away * turn.sin) * Vec3Lanes::of(other_radius));
  }
};

/// The upward direction, the radiance of the sky at the horizon, and what it gains up to the top and to the bottom.
struct SkyLight {
  float up[3], horizon[3], to_top[3], to_bottom[3];

  Vec3Lanes radiance(const Vec3Lanes& directions) const {
    const FloatLanes height = dot(directions, Vec3Lanes::of(up));
    return Vec3Lanes::of(horizon) + max(height, 0.0f) * Vec3Lanes::of(to_top) +
           max(-height, 0.0f) * Vec3Lanes::of(to_bottom);
  }
};

/// Unit vectors distributed evenly over the sphere.
inline Vec3Lanes sphere(const FloatLanes& first, const FloatLanes& second) {
  const FloatLanes height = 1.0f - 2.0f * first, radius = sqrt(max(1.0f - height * height, 0.0f));
  const SinCos turn = sincos(2.0f * kPi * second);
  return {radius * turn.cos, radius * turn.sin, height};
}

/// Unit vectors about normals, as many as the cosine of their angle.
inline Vec3Lanes hemisphere(const Vec3Lanes& normals, const FloatLanes& first, const FloatLanes& second) {
  return unit(normals + FloatLanes(0.9999f) * sphere(first, second));
}

}  // namespace fastlines
