// Where paths of light scatter: points at the surface of fibres, and where the rays that leave them start.
//
// The scattering model takes a fibre as a whole: light that leaves it, also on its other side, starts outside. So a ray
// in the direction ω from the point q, counted from the axis, starts where it leaves the fibre of the radius R:
//
//     t = (√((q·ω')² + |ω'|² (R² − |q|²)) − q·ω') / |ω'|²,     ω' the part of ω across the axis.
//
// Rays that are reflected start at once, and rays that pass the whole width start after 2R / cos θ.
#pragma once

#include <cstddef>

#include "../simd/lanes.hpp"

namespace fastlines {

struct LeavingTuning {
  /// The least |ω'|. A ray almost parallel to a straight fibre would leave it far away, but real fibres bend.
  static constexpr float kSteepest = 0.05f;
  /// Rays start this much farther, in radii: at a joint, the next segment bends away.
  static constexpr float kMargin = 0.02f;
};

/// Columns of n vertices: points at the surface, normals outwards, tangents, which are zero for surfaces without an
/// axis, directions towards where the light goes, and the radius of the fibre.
struct PathVertexRows {
  const float *points, *normals, *tangents, *to_eye, *radius;
  std::size_t n;
};

/// 16 vertices.
struct PathVertices {
  Vec3Lanes points, normals, tangents, to_eye;
  FloatLanes radius;

  static PathVertices load(const PathVertexRows& rows, std::size_t i, int count) {
    const auto vectors = [&](const float* from) { return Vec3Lanes::load(from + 3 * i, count); };
    return {vectors(rows.points), vectors(rows.normals), vectors(rows.tangents), vectors(rows.to_eye),
            load_lanes(rows.radius + i, count)};
  }

  /// The vertices at surfaces without an axis.
  IntLanes bare() const { return (tangents.x == 0.0f) & (tangents.y == 0.0f) & (tangents.z == 0.0f); }

  /// The offset of each ray from the axis of its fibre, in radii.
  FloatLanes h() const { return clamp(dot(normals, unit(cross(to_eye, tangents))), -1.0f, 1.0f); }

  /// How far rays in some directions are within the fibre that they start from; at least `least`.
  FloatLanes exits(const Vec3Lanes& directions, float least) const {
    const Vec3Lanes across = directions - dot(directions, tangents) * tangents;
    const Vec3Lanes away = normals - dot(normals, tangents) * tangents;
    const FloatLanes steep = max(dot(across, across), FloatLanes(LeavingTuning::kSteepest * LeavingTuning::kSteepest));
    const FloatLanes outwards = dot(away, across), rest = max(1.0f - dot(away, away), FloatLanes(0.0f));
    const FloatLanes chord = (sqrt(outwards * outwards + steep * rest) - outwards) / steep;
    return select(bare(), FloatLanes(0.0f), (chord + LeavingTuning::kMargin) * radius) + least;
  }
};

}  // namespace fastlines
