// Coherent rays as one thick ray: the blocks of the tree are read once for up to 64 of them.
//
// The bundle's axis is the line (C, c) of the rays' mean; U, V and c are a basis. Seen in it, a ray is a point that
// moves with depth z: (x, y) + z·(x', y'). It strays from the axis by no more than the greater of what it does at both
// depths between which the axis can be near the scene, for that distance is convex in z. With R = the largest stray +
// radius + rounding, what any of the rays comes near, the thick ray (C, c, R) comes near.
//
// thick.hpp searches a tree with it.
#pragma once

#include "cull.hpp"
#include "lanes.hpp"

namespace fastlines {

/// The thick ray around the rays of some lanes.
struct Bundle {
  int first = 0, end = 0;  // its lanes, whole groups of 16
  CullRay axis;
  Vec3 centre, u, v, c;     // from where lines are seen, and a basis, of which c is the axis's direction
  float stray = 0.0f;       // reach of the axis
  float spread = 0.0f;      // how far the rays stray from the axis
  float reach = 0.0f;       // of the rays: radius and rounding
  float slope = 0.0f;       // the largest |(x', y')|
  float grain = 0.0f;       // times |e|: what rounding may add to a line's moment
  bool from_point = false;  // whether all rays' lines pass through `centre`, as near as matters
  float depth = 0.0f;       // of `centre`

  // Rays beside the axis: at depth z at x + z·dx, y + z·dy; moment = x·dy − y·dx. Their depth is a + b·t; what begins
  // beyond `last` is no hit. All of this counts from the mean of the rays' origins.
  float x[kLanes], y[kLanes], dx[kLanes], dy[kLanes], moment[kLanes];
  float a[kLanes], b[kLanes], last[kLanes];

  /// Make the axis of rays [first, end); false if they do not run alike.
  bool gather(const RayLanes& rays, int first_, int end_, const Box& scene) {
    first = first_;
    end = end_;
    const Float4 directions = sums(rays.r);
    for (int k = 0; k < 3; ++k) c[k] = directions[k];
    const float length = std::sqrt(dot(c, c));
    if (!(length > 0.5f * float(end - first))) return false;
    const Float4 origins = sums(rays.o);
    for (int k = 0; k < 3; ++k) centre[k] = origins[k] / float(end - first);
    c = c * (1.0f / length);
    const float sign = std::copysign(1.0f, c[2]), f = -1.0f / (sign + c[2]), g = c[0] * c[1] * f;
    u = {1.0f + sign * c[0] * c[0] * f, sign * g, -sign * c[0]};
    v = {g, sign + c[1] * c[1] * f, -c[1]};

    // The depths of the scene's box along the axis.
    float middle = 0.0f, half = 0.001f;
    for (int k = 0; k < 3; ++k) {
      middle += c[k] * (0.5f * (scene.lo[k] + scene.hi[k]) - centre[k]);
      half += std::abs(c[k]) * 0.5f * (scene.hi[k] - scene.lo[k]);
    }
    Float16 largest = 0.0f;
    for (int i = first; i < end; i += kWidth) largest = max(largest, Float16::load(rays.reach + i));
    reach = greatest(largest);
    half += reach;
    Float16 stray2 = 0.0f, slope2 = 0.0f, slant = 1.0f, earliest = std::numeric_limits<float>::max();
    for (int i = first; i < end; i += kWidth) {
      const auto at = [i](const float (&from)[kLanes]) { return Float16::load(from + i); };
      const auto dot = [&](const Float16(&p)[3], const Vec3& axis_) {
        return fma(p[2], Float16(axis_[2]), fma(p[1], Float16(axis_[1]), p[0] * Float16(axis_[0])));
      };
      const Float16 p[3] = {at(rays.o[0]) - Float16(centre[0]), at(rays.o[1]) - Float16(centre[1]),
                            at(rays.o[2]) - Float16(centre[2])};
      const Float16 r[3] = {at(rays.r[0]), at(rays.r[1]), at(rays.r[2])};
      const Float16 at_depth = dot(p, c), step = dot(r, c), per_step = Float16(1.0f) / step;
      const Float16 x_step = dot(r, u) * per_step, y_step = dot(r, v) * per_step;
      const Float16 x_here = dot(p, u) - at_depth * x_step, y_here = dot(p, v) - at_depth * y_step;
      at_depth.store(a + i);
      step.store(b + i);
      x_step.store(dx + i);
      y_step.store(dy + i);
      x_here.store(x + i);
      y_here.store(y + i);
      (x_here * y_step - y_here * x_step).store(moment + i);
      for (const float z : {middle - half, middle + half}) {
        const Float16 off_x = fma(x_step, Float16(z), x_here), off_y = fma(y_step, Float16(z), y_here);
        stray2 = max(stray2, fma(off_x, off_x, off_y * off_y));
      }
      slope2 = max(slope2, fma(x_step, x_step, y_step * y_step));
      slant = min(slant, step);
      earliest = min(earliest, fma(step, max(at(rays.t_min), Float16(-8.0f)), at_depth));
    }
    if (!(least(slant) > 0.5f)) return false;
    spread = std::sqrt(greatest(stray2));
    slope = std::sqrt(greatest(slope2));
    grain = grain_from(centre);
    stray = reach + spread * 1.0002f + 4e-6f;
    axis = cull_ray(centre, c, u, v, stray, least(earliest) - spread - reach - 1e-5f);
    depth = 0.0f;
    find_point();
    return true;
  }

  /// Note the depths beyond which rays want nothing more, and return the greatest.
  float look(const float* limit) {
    Float16 deepest = -std::numeric_limits<float>::max();
    const Float16 more = reach + grain;
    for (int i = first; i < end; i += kWidth) {
      const Float16 here =
          fma(Float16::load(b + i), min(Float16::load(limit + i), Float16(8.0f)), Float16::load(a + i));
      (here + more).store(last + i);
      deepest = max(deepest, here);
    }
    return greatest(deepest) + stray;
  }

 private:
  /// Ulps of all that m is made of, seen from here.
  float grain_from(const Vec3& point) const {
    const float far = std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
    return (2.0f + far + spread) * 0x1p-17f;
  }

  /// If the rays' lines pass through one point, as those of a picture do, move `centre` there: then x, y and moment of
  /// all rays are noise, which counts as rounding.
  void find_point() {
    // The point that is nearest to the first and the last line.
    const int last_ray = end - 1;
    const float off_x = dx[last_ray] - dx[first], off_y = dy[last_ray] - dy[first];
    const float z =
        ((x[first] - x[last_ray]) * off_x + (y[first] - y[last_ray]) * off_y) / (off_x * off_x + off_y * off_y);
    from_point = std::abs(z) < 16.0f;  // else what is seen from there is coarse; it may be no number
    if (!from_point) return;
    const float at_x = x[first] + z * dx[first], at_y = y[first] + z * dy[first];
    const Vec3 point = centre + u * at_x + v * at_y + c * z;
    const float coarser = grain_from(point);
    Float16 wander2 = 0.0f;
    for (int i = first; i < end; i += kWidth) {
      const auto at = [i](const float (&from)[kLanes]) { return Float16::load(from + i); };
      const Float16 x_step = at(dx), y_step = at(dy);
      const Float16 x_here = fma(x_step, Float16(z), at(x)) - Float16(at_x);
      const Float16 y_here = fma(y_step, Float16(z), at(y)) - Float16(at_y);
      const Float16 moment_here = x_here * y_step - y_here * x_step;
      wander2 = max(wander2, fma(x_here, x_here, fma(y_here, y_here, moment_here * moment_here)));
    }
    const float wander = std::sqrt(greatest(wander2));
    from_point = wander < coarser;
    if (!from_point) return;
    centre = point;
    depth = z;
    grain = coarser + wander;
  }

  /// Of the rays' x, y and z; the fourth is nothing.
  Float4 sums(const float (&of)[3][kLanes]) const {
    Float4 fours[4] = {}, columns[4];
    for (int k = 0; k < 3; ++k)
      for (int i = first; i < end; i += 4) fours[k] += four(of[k] + i);
    turn(fours, columns);
    return (columns[0] + columns[1]) + (columns[2] + columns[3]);
  }
  static float greatest(Float16 x) { return -least(Float16(0.0f) - x); }
};

}  // namespace fastlines
