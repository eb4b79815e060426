// Line segments P + s·(Q − P), s in [0, 1].
//
// A cut is always evaluated from the original ends P and Q, in double, and rounded once: pieces of pieces do
// not drift, s grows with the plane, and a coordinate grows or falls with s. So cutting at two planes one
// after the other gives the very floats that cutting at each alone gives, which lets a split set count pieces
// in bins and be right about the tree that will come of it.
#pragma once

#include <span>

#include "primitives.hpp"

namespace fastlines {

struct Segment {
  Vec3 p, q;
};
static_assert(sizeof(Segment) == 24);

struct Segments {
  std::span<const Segment> data;

  std::size_t size() const { return data.size(); }

  Box bounds(std::uint32_t prim) const {
    Box box = Box::empty();
    box.grow(data[prim].p);
    box.grow(data[prim].q);
    return box;
  }

  /// The s at which the line crosses the plane x[axis] = plane, not clamped.
  float crossing(std::uint32_t prim, int axis, float plane) const {
    const Segment& segment = data[prim];
    const double p = segment.p[axis];
    return float((plane - p) * (1.0 / (segment.q[axis] - p)));
  }

  Vec3 point(std::uint32_t prim, float s) const {
    const Segment& segment = data[prim];
    if (s >= 1.0f) return segment.q;
    Vec3 at;
    for (int k = 0; k < 3; ++k) {
      const double p = segment.p[k];
      at[k] = float(p + double(s) * (segment.q[k] - p));
    }
    return at;
  }

  /// Whether s grows with x[axis].
  bool ascends(std::uint32_t prim, int axis) const { return data[prim].q[axis] >= data[prim].p[axis]; }

  Box clipped_bounds(std::uint32_t prim, const Box& box) const {
    const Segment& segment = data[prim];
    float s0 = 0.0f, s1 = 1.0f;
    for (int k = 0; k < 3; ++k) {
      const Box whole = bounds(prim);
      if (whole.hi[k] < box.lo[k] || whole.lo[k] > box.hi[k]) return Box::empty();
      if (segment.p[k] == segment.q[k]) continue;
      const float at_lo = crossing(prim, k, box.lo[k]), at_hi = crossing(prim, k, box.hi[k]);
      s0 = std::max(s0, std::min(at_lo, at_hi));
      s1 = std::min(s1, std::max(at_lo, at_hi));
    }
    if (s0 > s1) return Box::empty();
    Box clipped = Box::empty();
    clipped.grow(point(prim, s0));
    clipped.grow(point(prim, s1));
    for (int k = 0; k < 3; ++k) {
      clipped.lo[k] = std::clamp(clipped.lo[k], box.lo[k], box.hi[k]);
      clipped.hi[k] = std::clamp(clipped.hi[k], box.lo[k], box.hi[k]);
    }
    return clipped;
  }
};
static_assert(Curves<Segments>);

}  // namespace fastlines
