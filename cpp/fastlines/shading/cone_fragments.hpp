// Fragments of lines that are thinner than a pixel: those in the cone of each ray, from front to back.
//
// A line of radius r at the distance d from a ray covers K((d + r)/R) − K((d − r)/R) of a spot of radius R around the
// ray. K is the integral of the kernel of Epanechnikov. A strand counts once where it comes near: a hit at the end of a
// segment is left out if the strand goes on and comes nearer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "../math/vec.hpp"
#include "../memory/large_vector.hpp"

namespace fastlines {

/// The control points of axes, row by row; the first and the last of a row are the ends of an axis.
struct AxisPoints {
  std::span<const Vec3> points;
  std::size_t per_axis;

  std::size_t size() const { return points.size() / per_axis; }
  const Vec3& start(std::size_t i) const { return points[i * per_axis]; }
  const Vec3& end(std::size_t i) const { return points[(i + 1) * per_axis - 1]; }
  /// The direction at the start of an axis, of any length.
  Vec3 onward(std::size_t i) const { return points[i * per_axis + 1] - start(i); }
  /// Whether an axis begins where the one before it ends; not for numbers that no axis has.
  bool continues(std::size_t i) const { return i > 0 && i < size() && start(i) == end(i - 1); }
};

/// The hits of rays with unit directions, sorted by ray and then by t.
struct ConeHits {
  std::span<const std::int64_t> offsets, axis;  // of each ray its first hit, and the end; the row of each hit's axis
  std::span<const float> t, u, distance, own_radius;  // own_radius may be empty
  std::span<const Vec3> origins, directions;          // of each ray, or one origin for all
};

struct CoverSettings {
  float radius;  // added to the radii of lines
  float spread;  // the radius of a spot as a fraction of t
  float opaque;  // fragments behind this opacity are not drawn
  float faint;   // fragments of a smaller weight are drawn by chance
};

struct ConeFragments {
  LargeVector<std::int64_t> hit, ray;
  LargeVector<float> weight;
};

/// The integral of 3/4·(1 − x²) from −1.
inline float spot_share(float x) {
  x = std::clamp(x, -1.0f, 1.0f);
  return 0.5f + 0.75f * (x - x * x * x / 3.0f);
}

/// Whether a strand comes nearest at a hit, and not where an axis leads on to a nearer point.
inline bool comes_nearest(const AxisPoints& axes, std::size_t axis, float u, const Vec3& origin,
                          const Vec3& direction) {
  if (u <= 0.0f) return !axes.continues(axis);
  if (u < 1.0f || !axes.continues(axis + 1)) return true;
  // Compare the vector from the ray to the joint with the direction in which the strand goes on.
  const Vec3 point = axes.end(axis) - origin;
  const Vec3 away = point - direction * dot(point, direction), onward = axes.onward(axis + 1);
  double product = 0.0;
  for (int k = 0; k < 3; ++k) product += double(away[k]) * double(onward[k]);
  return !(product < 0.0);
}

/// Finds the fragments of all rays. `offsets` in [0, 1) of each ray choose among faint fragments, each for several. The
/// opacity of each ray is written.
inline ConeFragments cone_fragments(const ConeHits& hits, const AxisPoints& axes, const CoverSettings& settings,
                                    std::span<const float> offsets, std::span<float> opacity) {
  ConeFragments found;
  const bool one_origin = hits.origins.size() == 1, one_offset = offsets.size() == 1;
  for (std::size_t ray = 0; ray + 1 < hits.offsets.size(); ++ray) {
    const Vec3 &direction = hits.directions[ray], &origin = hits.origins[one_origin ? 0 : ray];
    // Light of a fragment passes what lies before it.
    double passed = 1.0, seen = 0.0;
    double steps = double(offsets[one_offset ? 0 : ray]);
    for (auto hit = std::size_t(hits.offsets[ray]); hit < std::size_t(hits.offsets[ray + 1]); ++hit) {
      if (!(passed > 1.0 - settings.opaque)) break;
      if (!comes_nearest(axes, std::size_t(hits.axis[hit]), hits.u[hit], origin, direction)) continue;
      const float width = settings.radius + (hits.own_radius.empty() ? 0.0f : hits.own_radius[hit]);
      const float spot = std::max(settings.spread * hits.t[hit], 1e-45f), distance = hits.distance[hit];
      const float cover = spot_share((distance + width) / spot) - spot_share((distance - width) / spot);
      const float weight = float(double(cover) * passed);
      passed *= 1.0 - double(std::min(cover, 0.9999f));
      seen += double(weight);
      // Keep some of the faint fragments: one for each full step of the sum of a ray's weights.
      const double before = std::floor(steps);
      steps += double(std::min(weight, settings.faint)) / double(settings.faint);
      if (weight < settings.faint && std::floor(steps) == before) continue;
      found.hit.push_back(std::int64_t(hit));
      found.ray.push_back(std::int64_t(ray));
      found.weight.push_back(std::max(weight, settings.faint));
    }
    opacity[ray] = float(seen);
  }
  return found;
}

}  // namespace fastlines
