// The exact test of a shape, which is a round cone, a triangle or a box, and the fields that the test reads.
//
// GPUs compile this file too (device/kernels.hpp).
#pragma once

#include "axis_fields.hpp"
#include "box_test.hpp"
#include "round_cone_test.hpp"
#include "triangle_test.hpp"

namespace fastlines {

/// The fields of a shape: eight of a round cone, or nine coordinates of a triangle or a box; and its kind.
inline constexpr int kShapeFields = 10;

/// Compute the fields of a shape, in the frame. `floats` is the shape as the caller gave it.
template <class N, class Frame>
[[gnu::always_inline]] inline std::array<N, kShapeFields> shape_fields(const N (&floats)[kShapeFields],
                                                                       const Frame& frame) {
  const N(&cone)[8] = reinterpret_cast<const N(&)[8]>(floats);
  const std::array<N, 8> of_cone = round_cone_fields(cone, frame);
  const auto is_cone = floats[9] < N(0.5f);
  std::array<N, kShapeFields> fields;
  for (int k = 0; k < 9; ++k) {
    const N coordinate = (floats[k] - N(frame.centre[k % 3])) * N(frame.scale);
    fields[k] = k < 8 ? blend(is_cone, of_cone[k], coordinate) : coordinate;
  }
  fields[9] = floats[9];
  return fields;
}

/// Tests one ray with one shape, or 16 of either. It must not outlive the ray.
template <class N, class R>
class ShapeTest {
 public:
  template <class V>
  [[gnu::always_inline]] ShapeTest(const R& ray, const V& fields) : ray_(ray) {
    for (int k = 0; k < kShapeFields; ++k) fields_[k] = fields[k];
    find_closest();
  }

  /// Return where the ray enters the shape, within the bounds of the ray. The ray must hit.
  [[gnu::always_inline]] ClosestApproach<N> entry() const {
    ClosestApproach<N> found = closest;
    if (any(is_cone())) blend_into(is_cone(), RoundConeTest<N, R>(ray_, fields_).entry(), found);
    return found;
  }

  /// Return whether a ray with this entry comes in from outside. A triangle has no inside: each crossing enters.
  [[gnu::always_inline]] MaskOf<N> enters(const ClosestApproach<N>& entry) const {
    return is_triangle() | (N(ray_.t_min) < entry.t);
  }

  /// Return the t at which the ray leaves the shape.
  [[gnu::always_inline]] N exit() const {
    N t = flat_exit_;
    if (any(is_cone())) t = blend(is_cone(), RoundConeTest<N, R>(ray_, fields_).exit(), t);
    return t;
  }

 private:
  [[gnu::always_inline]] MaskOf<N> is_cone() const { return fields_[9] < N(0.5f); }
  [[gnu::always_inline]] MaskOf<N> is_triangle() const { return (N(0.5f) < fields_[9]) & (fields_[9] < N(1.5f)); }

  [[gnu::always_inline]] static void blend_into(const MaskOf<N>& mask, const ClosestApproach<N>& from,
                                                ClosestApproach<N>& to) {
    to.s = blend(mask, from.s, to.s);
    to.t = blend(mask, from.t, to.t);
    to.dist2 = blend(mask, from.dist2, to.dist2);
    to.hit = (mask & from.hit) | to.hit;  // no lane in the mask has hit before
  }

  [[gnu::always_inline]] void find_closest() {
    const N zero = 0.0f, kind = fields_[9];
    const MaskOf<N> is_triangle = this->is_triangle(), is_box = N(1.5f) < kind;
    closest = {zero, zero, zero, zero < zero};
    flat_exit_ = zero;
    if (any(is_triangle)) {
      const TriangleHit<N> found = meet_triangle<N>(ray_, fields_, is_triangle);
      const MaskOf<N> hit = is_triangle & found.hit & (N(ray_.t_min) <= found.t) & (found.t <= N(ray_.t_max));
      flat_exit_ = blend(is_triangle, found.t, flat_exit_);
      blend_into(is_triangle, {zero, found.t, zero, hit}, closest);
    }
    if (any(is_box)) {
      const N grow = blend(N(2.5f) < kind, sqrt(N(ray_.radius2)), zero);
      const BoxHit<N> found = meet_box<N>(ray_, fields_, grow);
      flat_exit_ = blend(is_box, found.t_out, flat_exit_);
      blend_into(is_box, {zero, found.t, zero, MaskOf<N>(is_box & found.hit)}, closest);
    }
    if (any(is_cone())) blend_into(is_cone(), RoundConeTest<N, R>(ray_, fields_).closest, closest);
  }

  const R& ray_;
  std::array<N, kShapeFields> fields_;
  N flat_exit_;  // where the ray leaves a triangle or a box

 public:
  ClosestApproach<N> closest;
};
}  // namespace fastlines
