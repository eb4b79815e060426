// Shapes: round cones, triangles and boxes, in any mixture, as one set of primitives.
//
// Boxes of a tree over shapes bound whole shapes, radii included. A shape that is cut by planes is referenced as a
// whole in each leaf that has a part of it, so queries may find it several times, and count it once.
#pragma once

#include <cstring>
#include <span>

#include "box_test.hpp"
#include "round_cone_clip.hpp"
#include "round_cones.hpp"
#include "triangle.hpp"
#include "triangle_test.hpp"

namespace fastlines {

/// One shape. Every number is a float, so that a row of an array holds it.
struct Shape {
  enum Kind { round_cone, triangle, box, bound };

  /// A round cone: both ends of its axis, and their radii. A triangle: its corners. A box: its low and high corner. A
  /// bound: the same of what only the caller can test; the radius of a query grows it.
  float numbers[9];
  float kind_number;  ///< its kind

  Kind kind() const { return Kind(int(kind_number)); }

  template <class As>
  const As& as() const {
    static_assert(sizeof(As) <= sizeof numbers);
    return reinterpret_cast<const As&>(numbers);
  }
};
static_assert(sizeof(Shape) == 40);

/// A round cone, a triangle or a box as a shape.
template <class From>
Shape shape_of(Shape::Kind kind, const From& from) {
  static_assert(sizeof(From) <= sizeof(Shape::numbers));
  Shape shape{{}, float(kind)};
  std::memcpy(shape.numbers, &from, sizeof from);
  return shape;
}

template <class N, class R>
class ShapeTest;

/// Shapes as a set of primitives, for builders and for the fast path.
struct Shapes {
  using Item = Shape;
  static constexpr const char* kKind = "shapes";
  static constexpr int kFields = 10;  // those of a round cone, or nine coordinates; and the kind

  std::span<const Shape> data;

  std::size_t size() const { return data.size(); }
  const Shape* items() const { return data.data(); }
  const Shape& item(std::uint32_t prim) const { return data[prim]; }

  Box bounds(std::uint32_t prim) const {
    const Shape& shape = data[prim];
    switch (shape.kind()) {
      case Shape::round_cone:
        return bounds_of(shape.as<RoundCone>());
      case Shape::triangle:
        return shape.as<Triangle>().bounds();
      default:
        return shape.as<Box>();
    }
  }

  Box clipped_bounds(std::uint32_t prim, const Box& box) const {
    const Shape& shape = data[prim];
    switch (shape.kind()) {
      case Shape::round_cone:
        return clipped_bounds_of(shape.as<RoundCone>(), box);
      case Shape::triangle:
        return shape.as<Triangle>().clipped_bounds(box);
      default:
        return intersection(shape.as<Box>(), box);
    }
  }

  static bool has_axis(const Shape& shape) { return shape.kind() == Shape::round_cone; }
  static const Segment& axis(const Shape& shape) { return shape.as<Segment>(); }
  static float radius(const Shape& shape) { return RoundCones::radius(shape.as<RoundCone>()); }

  template <class N, class Frame>
  [[gnu::always_inline]] static std::array<N, kFields> fields(const N (&floats)[10], const Frame& frame) {
    const N(&cone)[8] = reinterpret_cast<const N(&)[8]>(floats);
    const std::array<N, 8> of_cone = RoundCones::fields(cone, frame);
    const auto is_cone = floats[9] < N(0.5f);
    std::array<N, kFields> fields;
    for (int k = 0; k < 9; ++k) {
      const N coordinate = (floats[k] - N(frame.centre[k % 3])) * N(frame.scale);
      fields[k] = k < 8 ? blend(is_cone, of_cone[k], coordinate) : coordinate;
    }
    fields[9] = floats[9];
    return fields;
  }

  template <class N, class R, class V>
  [[gnu::always_inline]] static ShapeTest<N, R> test(const R& ray, const V& fields) {
    return {ray, fields};
  }
};

/// The test of one ray and one shape, or of 16 of either. It must not outlive the ray.
template <class N, class R>
class ShapeTest {
 public:
  template <class V>
  [[gnu::always_inline]] ShapeTest(const R& ray, const V& fields) : ray_(ray) {
    for (int k = 0; k < Shapes::kFields; ++k) fields_[k] = fields[k];
    find_closest();
  }

  /// Where a ray that hits enters the shape, within its bounds.
  [[gnu::always_inline]] ClosestApproach<N> entry() const {
    ClosestApproach<N> found = closest;
    if (any(is_cone())) blend_into(is_cone(), RoundConeTest<N, R>(ray_, fields_).entry(), found);
    return found;
  }

  /// Where it leaves.
  [[gnu::always_inline]] N exit() const {
    N t = flat_exit_;
    if (any(is_cone())) t = blend(is_cone(), RoundConeTest<N, R>(ray_, fields_).exit(), t);
    return t;
  }

 private:
  [[gnu::always_inline]] MaskOf<N> is_cone() const { return fields_[9] < N(0.5f); }

  [[gnu::always_inline]] static void blend_into(const MaskOf<N>& mask, const ClosestApproach<N>& from,
                                                ClosestApproach<N>& to) {
    to.s = blend(mask, from.s, to.s);
    to.t = blend(mask, from.t, to.t);
    to.dist2 = blend(mask, from.dist2, to.dist2);
    to.hit = (mask & from.hit) | to.hit;  // of the lanes in the mask none has hit yet
  }

  [[gnu::always_inline]] void find_closest() {
    const N zero = 0.0f, kind = fields_[9];
    const MaskOf<N> is_triangle = (N(0.5f) < kind) & (kind < N(1.5f)), is_box = N(1.5f) < kind;
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
  std::array<N, Shapes::kFields> fields_;
  N flat_exit_;  // where the ray leaves a triangle or a box

 public:
  ClosestApproach<N> closest;
};
static_assert(MixedPrimitive<Shapes>);

}  // namespace fastlines
