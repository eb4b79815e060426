// Coherent rays as one thick ray, so that up to 64 of them read each block of the tree once.
//
// The axis (C, c) of the bundle is the mean line of the rays, and U, V, c are an orthonormal basis. In it, a ray is a
// point that moves with the depth z: (x, y) + z·(x', y'). Its distance from the axis is convex in z. So between two
// depths, the larger of the distances at these depths bounds it. With the depths of the scene's box,
//
//     R = the largest of these bounds + radius + rounding,
//
// the thick ray (C, c, R) accepts what any of the rays accepts. BundleTraversal searches a tree with it.
#pragma once

#include "../intersect/node_cull.hpp"
#include "../rays/ray_group.hpp"

namespace fastlines {

/// The thick ray around the rays in lanes [first, end) of a group. Lengths are in the frame.
struct RayBundle {
  int first = 0, end = 0;  // its lanes, whole packets
  CullRay axis;
  Vec3 centre, u, v, c;      // origin and basis of the line test; c is the direction of the axis
  float offset = 0.0f;       // R, the culling radius of the axis
  float divergence = 0.0f;   // the largest distance of a ray from the axis near the scene
  float cull_radius = 0.0f;  // the largest culling radius of a ray
  float slope = 0.0f;        // the largest |(x', y')|
  float resolution = 0.0f;   // rounding may change the moment m of a line by resolution · |e|
  bool from_apex = false;    // whether the lines of all rays pass through `centre`, up to `resolution`
  float depth = 0.0f;        // of `centre`, from the mean of the rays' origins
  float max_abs_t = 0.0f;    // bounds on t are clamped to ± this, which lies outside the scene

  /// Rays in the basis U, V, c around the mean of their origins. At depth z a ray is at (x + z·dx, y + z·dy), and its
  /// moment is x·dy − y·dx. At t its depth is depth_at_0 + depth_per_t·t. No hit begins beyond max_depth.
  float x[kGroupSize], y[kGroupSize], dx[kGroupSize], dy[kGroupSize], moment[kGroupSize];
  float depth_at_0[kGroupSize], depth_per_t[kGroupSize], max_depth[kGroupSize];

  /// Fit the bundle to the rays in lanes [first, end), whole packets. Returns false if their directions are not
  /// coherent; then the bundle is not usable.
  bool try_fit(const RayGroup& rays, int first_, int end_, const Box& scene) {
    first = first_;
    end = end_;
    // Fit the axis, and choose a basis around it.
    const FloatX4 directions = sum(rays.r);
    for (int k = 0; k < 3; ++k) c[k] = directions[k];
    const float length = std::sqrt(dot(c, c));
    if (!(length > 0.5f * float(end - first))) return false;
    const FloatX4 origins = sum(rays.o);
    for (int k = 0; k < 3; ++k) centre[k] = origins[k] / float(end - first);
    c = c * (1.0f / length);
    const float sign = std::copysign(1.0f, c[2]), f = -1.0f / (sign + c[2]), g = c[0] * c[1] * f;
    u = {1.0f + sign * c[0] * c[0] * f, sign * g, -sign * c[0]};
    v = {g, sign + c[1] * c[1] * f, -c[1]};

    // Bound the depths of the scene's box: middle ± half.
    float middle = 0.0f, half = 0.001f;
    for (int k = 0; k < 3; ++k) {
      middle += c[k] * (0.5f * (scene.lo[k] + scene.hi[k]) - centre[k]);
      half += std::abs(c[k]) * 0.5f * (scene.hi[k] - scene.lo[k]);
    }
    float farthest = 1.0f;  // thick primitives reach beyond the frame
    for (int k = 0; k < 3; ++k) farthest = std::max({farthest, std::abs(scene.lo[k]), std::abs(scene.hi[k])});
    max_abs_t = 8.0f * farthest;
    FloatX16 largest = 0.0f;
    for (int i = first; i < end; i += kSimdWidth) largest = max(largest, FloatX16::load(rays.cull_radius + i));
    cull_radius = reduce_max(largest);
    half += cull_radius;
    // Transform the rays into the basis, and bound their distances from the axis.
    FloatX16 offset2 = 0.0f, slope2 = 0.0f, min_cosine = 1.0f, earliest = std::numeric_limits<float>::max();
    for (int i = first; i < end; i += kSimdWidth) {
      const auto at = [i](const float (&from)[kGroupSize]) { return FloatX16::load(from + i); };
      const auto dot = [&](const FloatX16(&p)[3], const Vec3& axis_) {
        return fma(p[2], FloatX16(axis_[2]), fma(p[1], FloatX16(axis_[1]), p[0] * FloatX16(axis_[0])));
      };
      const FloatX16 p[3] = {at(rays.o[0]) - FloatX16(centre[0]), at(rays.o[1]) - FloatX16(centre[1]),
                             at(rays.o[2]) - FloatX16(centre[2])};
      const FloatX16 r[3] = {at(rays.r[0]), at(rays.r[1]), at(rays.r[2])};
      const FloatX16 at_depth = dot(p, c), step = dot(r, c), per_step = FloatX16(1.0f) / step;
      const FloatX16 x_step = dot(r, u) * per_step, y_step = dot(r, v) * per_step;
      const FloatX16 x_here = dot(p, u) - at_depth * x_step, y_here = dot(p, v) - at_depth * y_step;
      at_depth.store(depth_at_0 + i);
      step.store(depth_per_t + i);
      x_step.store(dx + i);
      y_step.store(dy + i);
      x_here.store(x + i);
      y_here.store(y + i);
      (x_here * y_step - y_here * x_step).store(moment + i);
      for (const float z : {middle - half, middle + half}) {
        const FloatX16 off_x = fma(x_step, FloatX16(z), x_here), off_y = fma(y_step, FloatX16(z), y_here);
        offset2 = max(offset2, fma(off_x, off_x, off_y * off_y));
      }
      slope2 = max(slope2, fma(x_step, x_step, y_step * y_step));
      min_cosine = min(min_cosine, step);
      earliest = min(earliest, fma(step, max(at(rays.t_min), FloatX16(-max_abs_t)), at_depth));
    }
    if (!(reduce_min(min_cosine) > 0.5f)) return false;
    divergence = std::sqrt(reduce_max(offset2));
    slope = std::sqrt(reduce_max(slope2));
    resolution = resolution_from(centre);
    offset = cull_radius + divergence * 1.0002f + 4e-6f;
    axis = cull_ray(centre, c, u, v, offset, reduce_min(earliest) - divergence - cull_radius - 1e-5f);
    depth = 0.0f;
    find_apex();
    return true;
  }

  /// Set max_depth from the limits of the rays, t in the frame. Returns the t of the axis beyond which no ray needs
  /// hits.
  float update_depths(const float* limit) {
    FloatX16 deepest = -std::numeric_limits<float>::max();
    const FloatX16 more = cull_radius + resolution;
    for (int i = first; i < end; i += kSimdWidth) {
      const FloatX16 here = fma(FloatX16::load(depth_per_t + i), min(FloatX16::load(limit + i), FloatX16(max_abs_t)),
                                FloatX16::load(depth_at_0 + i));
      (here + more).store(max_depth + i);
      deepest = max(deepest, here);
    }
    return reduce_max(deepest) + offset;
  }

 private:
  /// A bound on the rounding of m per |e|, in a basis around this point: 64 float epsilons times a bound on the
  /// coordinates that m is made of.
  float resolution_from(const Vec3& point) const {
    const float far = std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
    return (2.0f + far + divergence) * 0x1p-17f;
  }

  /// If the lines of all rays pass through one point, as those of a pinhole camera do, move `centre` there. From there,
  /// x, y and moment of all rays are noise; it is added to `resolution`.
  void find_apex() {
    // Find the point nearest to the first and the last line.
    const int last_ray = end - 1;
    const float off_x = dx[last_ray] - dx[first], off_y = dy[last_ray] - dy[first];
    const float z =
        ((x[first] - x[last_ray]) * off_x + (y[first] - y[last_ray]) * off_y) / (off_x * off_x + off_y * off_y);
    from_apex = std::abs(z) < 16.0f;  // farther away, precision is lost; z may be NaN
    if (!from_apex) return;
    const float at_x = x[first] + z * dx[first], at_y = y[first] + z * dy[first];
    const Vec3 point = centre + u * at_x + v * at_y + c * z;
    const float point_resolution = resolution_from(point);
    // Measure by how much the lines miss it.
    FloatX16 deviation2 = 0.0f;
    for (int i = first; i < end; i += kSimdWidth) {
      const auto at = [i](const float (&from)[kGroupSize]) { return FloatX16::load(from + i); };
      const FloatX16 x_step = at(dx), y_step = at(dy);
      const FloatX16 x_here = fma(x_step, FloatX16(z), at(x)) - FloatX16(at_x);
      const FloatX16 y_here = fma(y_step, FloatX16(z), at(y)) - FloatX16(at_y);
      const FloatX16 moment_here = x_here * y_step - y_here * x_step;
      deviation2 = max(deviation2, fma(x_here, x_here, fma(y_here, y_here, moment_here * moment_here)));
    }
    const float deviation = std::sqrt(reduce_max(deviation2));
    from_apex = deviation < point_resolution;
    if (!from_apex) return;
    centre = point;
    depth = z;
    resolution = point_resolution + deviation;
  }

  /// The sums of x, y and z over the rays; lane 3 is padding.
  FloatX4 sum(const float (&points)[3][kGroupSize]) const {
    FloatX4 fours[4] = {}, columns[4];
    for (int k = 0; k < 3; ++k)
      for (int i = first; i < end; i += 4) fours[k] += load_x4(points[k] + i);
    transpose(fours, columns);
    return (columns[0] + columns[1]) + (columns[2] + columns[3]);
  }
};

}  // namespace fastlines
