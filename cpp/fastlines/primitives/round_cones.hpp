// Round cones: all points within r(s) of the point P + s·(Q − P) of an axis, where r(s) = r₀ + s·(r₁ − r₀) and s is in
// [0, 1]. Equal radii make a capsule, an axis of length zero makes a ball. If one end's ball contains the other, the
// round cone is that ball.
//
// A tree over round cones is a tree over their axes: a radius of its own and the radius of a query have the same effect
// on a ray. The layout grows the boxes of its nodes by the radii, so that a wide node bounds whole round cones.
#pragma once

#include <algorithm>

#include "ray_primitive.hpp"
#include "round_cone_test.hpp"

namespace fastlines {

struct RoundCone {
  Segment axis;
  float radius0, radius1;
};
static_assert(sizeof(RoundCone) == 32);

/// Round cones as a set of primitives for the fast path. Builders see their axes.
class RoundCones {
 public:
  using Item = RoundCone;
  static constexpr const char* kKind = "round cones";
  static constexpr int kFields = 8;  // start, end − start, radius at the start, difference of the radii
  static constexpr bool kHasRadius = true;

  explicit RoundCones(std::span<const RoundCone> cones) : cones_(cones) {
    for (const RoundCone& cone : cones) max_radius_ = std::max(max_radius_, radius(cone));
  }
  /// The same, where the largest radius is known: a file of them is then read only where queries need it.
  RoundCones(std::span<const RoundCone> cones, float max_radius) : cones_(cones), max_radius_(max_radius) {}

  // For builders: the axes.
  std::size_t size() const { return cones_.size(); }
  const Segment& curve(std::uint32_t prim) const { return cones_[prim].axis; }
  Box bounds(std::uint32_t prim) const { return curve(prim).bounds(); }
  Box clipped_bounds(std::uint32_t prim, const Box& box) const { return curve(prim).clipped_bounds(box); }

  // For the fast path.
  const RoundCone* items() const { return cones_.data(); }
  const RoundCone& item(std::uint32_t prim) const { return cones_[prim]; }
  static const Segment& axis(const RoundCone& cone) { return cone.axis; }
  static float radius(const RoundCone& cone) { return std::max(cone.radius0, cone.radius1); }
  float max_radius() const { return max_radius_; }

  template <class N, class Frame>
  [[gnu::always_inline]] static std::array<N, kFields> fields(const N (&floats)[8], const Frame& frame) {
    return round_cone_fields(floats, frame);
  }

  template <class N>
  [[gnu::always_inline]] static N frame_radius(const std::array<N, kFields>& fields) {
    return max(fields[6], fields[6] + fields[7]);
  }

  template <class N, class R, class V>
  [[gnu::always_inline]] static RoundConeTest<N, R> test(const R& ray, const V& fields) {
    return {ray, fields};
  }

 private:
  std::span<const RoundCone> cones_;
  float max_radius_ = 0.0f;
};
static_assert(AxisPrimitive<RoundCones>);

}  // namespace fastlines
