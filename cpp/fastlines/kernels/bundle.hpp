// Coherent rays as one thick ray: the blocks of the tree are read once for up to 64 of them.
//
// The bundle's axis is the line (C, c) of the rays' mean. A ray has the depth a + b·t along it. Between the depths at
// which the axis can be near the scene it strays from the axis by no more than the greater of what it does at both
// ends, for the distance of two points that move along lines is convex. With R = the largest stray + radius + rounding,
// what any of the rays comes near, the thick ray (C, c, R) comes near.
//
// What survives its culling is tested against all rays, sixteen at a time, each segment once. What is in reach goes to
// a collector (collect.hpp), which also tells each ray's limit.
#pragma once

#include "collect.hpp"
#include "seen_set.hpp"
#include "stack.hpp"

namespace fastlines {

/// The thick ray around the rays of some lanes.
struct Bundle {
  int first = 0, end = 0;  // its lanes, whole groups of 16
  CullRay axis;
  float spread = 0.0f;
  float a[kLanes], b[kLanes];  // depth of a ray along the axis: a + b·t

  /// Make the axis of rays [first, end); false if they do not run alike.
  bool gather(const RayLanes& rays, int first_, int end_, const Box& scene) {
    first = first_;
    end = end_;
    Vec3 centre, c;
    for (int k = 0; k < 3; ++k) {
      centre[k] = sum(rays.o[k]) / float(end - first);
      c[k] = sum(rays.r[k]);
    }
    const float length = std::sqrt(dot(c, c));
    if (!(length > 0.5f * float(end - first))) return false;
    c = c * (1.0f / length);

    // The depths of the scene's box along the axis.
    float middle = 0.0f, half = 0.0f;
    for (int k = 0; k < 3; ++k) {
      middle += c[k] * (0.5f * (scene.lo[k] + scene.hi[k]) - centre[k]);
      half += std::abs(c[k]) * 0.5f * (scene.hi[k] - scene.lo[k]);
    }
    Float16 largest = 0.0f, slant = 1.0f;
    for (int i = first; i < end; i += kWidth) {
      largest = max(largest, Float16::load(rays.radius + i) + Float16::load(rays.eps + i));
      const auto at = [i](const float (&x)[kLanes]) { return Float16::load(x + i); };
      Float16 depth = 0.0f, step = 0.0f;
      for (int k = 0; k < 3; ++k) {
        depth = fma(at(rays.o[k]) - Float16(centre[k]), Float16(c[k]), depth);
        step = fma(at(rays.r[k]), Float16(c[k]), step);
      }
      depth.store(a + i);
      step.store(b + i);
      slant = min(slant, step);
    }
    if (!(least(slant) > 0.5f)) return false;
    const float reach = greatest(largest);
    half += reach + 0.001f;
    Float16 stray2 = 0.0f, earliest = std::numeric_limits<float>::max();
    for (int i = first; i < end; i += kWidth) {
      const auto at = [i](const float (&x)[kLanes]) { return Float16::load(x + i); };
      for (const float depth : {middle - half, middle + half}) {
        const Float16 t = (Float16(depth) - at(a)) / at(b);
        Float16 off2 = 0.0f;
        for (int k = 0; k < 3; ++k) {
          const Float16 off = fma(at(rays.r[k]), t, at(rays.o[k])) - Float16(centre[k] + c[k] * depth);
          off2 = fma(off, off, off2);
        }
        stray2 = max(stray2, off2);
      }
      earliest = min(earliest, fma(at(b), max(at(rays.t_min), Float16(-8.0f)), at(a)));
    }
    spread = std::sqrt(greatest(stray2));
    const float sign = std::copysign(1.0f, c[2]), f = -1.0f / (sign + c[2]), g = c[0] * c[1] * f;
    axis =
        CullRay(centre, c, {1.0f + sign * c[0] * c[0] * f, sign * g, -sign * c[0]}, {g, sign + c[1] * c[1] * f, -c[1]},
                reach + spread * 1.0002f + 4e-6f, least(earliest) - spread - reach - 1e-5f);
    return true;
  }

  /// The greatest depth at which any ray may still find something.
  float deepest(const float* limit) const {
    Float16 deepest = -std::numeric_limits<float>::max();
    for (int i = first; i < end; i += kWidth)
      deepest =
          max(deepest, fma(Float16::load(b + i), min(Float16::load(limit + i), Float16(8.0f)), Float16::load(a + i)));
    return greatest(deepest) + axis.reach;
  }

 private:
  float sum(const float (&x)[kLanes]) const {
    float sum = 0.0f;
    for (int i = first; i < end; ++i) sum += x[i];
    return sum;
  }
  static float greatest(Float16 x) { return -least(Float16(0.0f) - x); }
};

/// Show the collector what the rays of a bundle come near.
template <class Collector>
void search_bundle(const WideView& tree, const RayLanes& rays, const Bundle& bundle, Collector& collector, Stack& stack,
                   SeenSet& seen) {
  float deepest = bundle.deepest(collector.limit);
  seen.clear();

  const auto test = [&](std::uint32_t prim) {
    const Segment& segment = tree.segments[prim];
    const Vec3 start = tree.frame(segment.p), e = tree.frame(segment.q) - start;
    for (int first = bundle.first; first < bundle.end; first += kWidth) {
      const auto at = [first](const float* x) { return Float16::load(x + first); };
      const Rays16 sixteen(rays, first);
      const Seen<Float16> g = see<Float16>(sixteen, start, e);
      // The line of the segment out of reach, or its nearer end beyond the limit: no need to look closer.
      const Float16 reach = at(rays.radius) + at(rays.eps), cross = g.pu * g.ev - g.pv * g.eu;
      const Mask16 near = (cross * cross <= fma(g.ee, reach * reach, Float16(1e-30f))) &
                          (g.pr + min(g.er, Float16(0.0f)) - reach <= at(collector.limit));
      if (!any(near)) continue;
      const Approach<Float16> approach = closest_approach(sixteen, g);
      const std::uint32_t hit = (approach.hit & near).bits();
      if (hit) collector.take(rays, first, hit, approach, prim);
    }
  };
  stack.clear();
  stack.visit(tree.nodes[0], bundle.axis, deepest);
  while (!stack.empty()) {
    const auto [child, at] = stack.pop();
    if (!(at <= deepest)) continue;
    if (!(child & kLeaf)) {
      stack.visit(tree.nodes[child], bundle.axis, deepest);
      continue;
    }
    const WideLeaf& leaf = tree.leaves[child & ~kLeaf];
    for (std::uint32_t lanes = cull_leaf(bundle.axis, leaf, LeafPlace(bundle.axis, leaf)); lanes; lanes &= lanes - 1) {
      const std::uint32_t prim = tree.refs[leaf.first_ref + std::uint32_t(std::countr_zero(lanes))].prim;
      if (seen.insert(prim)) test(prim);
    }
    if (collector.closer) {
      collector.closer = false;
      deepest = bundle.deepest(collector.limit);
    }
  }
}

}  // namespace fastlines
