// Line segments P + s·(Q − P), s in [0, 1].
//
// A cut is always computed from the original ends P and Q, in double, and rounded once. So pieces of pieces do not
// drift, s is monotonic in the position of the plane, and each coordinate is monotonic in s. Therefore cutting at two
// planes one after the other gives the same floats as cutting at each alone. A split set may count pieces in bins: its
// counts are those of the tree that results.
#pragma once

#include <span>

#include "axis_fields.hpp"
#include "primitive.hpp"
#include "segment_test.hpp"

namespace fastlines {

struct Segment {
  Vec3 p, q;

  Box bounds() const {
    Box box = Box::empty();
    box.grow(p);
    box.grow(q);
    return box;
  }

  /// The s at which the line crosses the plane x[axis] = plane, not clamped.
  float crossing(int axis, float plane) const {
    const double from = p[axis];
    return float((plane - from) * (1.0 / (q[axis] - from)));
  }

  /// The point at s, rounded to float32; q for s ≥ 1.
  Vec3 point(float s) const {
    Vec3 at;
    for (int k = 0; k < 3; ++k) {
      const double from = p[k];
      at[k] = s < 1.0f ? float(from + double(s) * (q[k] - from)) : q[k];
    }
    return at;
  }

  /// Whether x[axis] grows with s, or stays the same.
  bool ascends(int axis) const { return q[axis] >= p[axis]; }

  /// The box of the part in `box`; empty if there is none.
  Box clipped_bounds(const Box& box) const {
    const Box whole = bounds();
    float s0 = 0.0f, s1 = 1.0f;
    for (int k = 0; k < 3; ++k) {
      if (whole.hi[k] < box.lo[k] || whole.lo[k] > box.hi[k]) return Box::empty();
      if (whole.lo[k] == whole.hi[k]) continue;
      const float at_lo = crossing(k, box.lo[k]), at_hi = crossing(k, box.hi[k]);
      s0 = std::max(s0, std::min(at_lo, at_hi));
      s1 = std::min(s1, std::max(at_lo, at_hi));
    }
    if (s0 > s1) return Box::empty();
    Box clipped = Box::empty();
    clipped.grow(point(s0));
    clipped.grow(point(s1));
    for (int k = 0; k < 3; ++k) {
      clipped.lo[k] = std::clamp(clipped.lo[k], box.lo[k], box.hi[k]);
      clipped.hi[k] = std::clamp(clipped.hi[k], box.lo[k], box.hi[k]);
    }
    return clipped;
  }
};
static_assert(sizeof(Segment) == 24);

/// Segments as a set of primitives, for builders (`Primitives`, `Curves`) and for the fast path (`RayPrimitive`).
struct Segments {
  using Item = Segment;
  static constexpr const char* kKind = "segments";
  static constexpr int kFields = 6;  // start, end − start
  static constexpr bool kHasRadius = false;

  std::span<const Segment> data;

  std::size_t size() const { return data.size(); }
  const Segment* items() const { return data.data(); }
  const Segment& item(std::uint32_t prim) const { return data[prim]; }
  static const Segment& axis(const Segment& segment) { return segment; }
  static float radius(const Segment&) { return 0.0f; }
  static float max_radius() { return 0.0f; }

  /// The start and end − start, in the frame.
  template <class N, class Frame>
  [[gnu::always_inline]] static std::array<N, kFields> fields(const N (&floats)[6], const Frame& frame) {
    return segment_fields(floats, frame);
  }

  template <class N>
  static N frame_radius(const std::array<N, kFields>&) {
    return 0.0f;
  }

  template <class N, class R, class V>
  [[gnu::always_inline]] static SegmentTest<N, R> test(const R& ray, const V& fields) {
    return {ray, fields};
  }

  const Segment& curve(std::uint32_t prim) const { return data[prim]; }
  Box bounds(std::uint32_t prim) const { return data[prim].bounds(); }

  Box clipped_bounds(std::uint32_t prim, const Box& box) const { return data[prim].clipped_bounds(box); }
};
static_assert(Curves<Segments>);

/// A set of curves that are straight segments.
template <class P>
concept Straight = Curves<P> && requires(const P& prims, std::uint32_t prim) {
  { prims.curve(prim) } -> std::same_as<const Segment&>;
};

/// Prefetch a primitive, if its address is known.
template <Primitives P>
void prefetch(const P& prims, std::uint32_t prim) {
  if constexpr (Straight<P>) __builtin_prefetch(&prims.curve(prim));
}

}  // namespace fastlines
