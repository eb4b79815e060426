// Shapes: round cones, triangles and boxes, in any mixture, as one set of primitives.
//
// Boxes of a tree over shapes bound whole shapes, radii included. A shape that is cut by planes is referenced as a
// whole in each leaf that has a part of it, so queries may find it several times, and count it once.
#pragma once

#include <cstring>
#include <span>

#include "round_cone_clip.hpp"
#include "round_cones.hpp"
#include "shape_test.hpp"
#include "triangle.hpp"
#include "triangle_test_x16.hpp"

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

/// Shapes as a set of primitives, for builders and for the fast path.
struct Shapes {
  using Item = Shape;
  static constexpr const char* kKind = "shapes";
  static constexpr int kFields = kShapeFields;

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
  [[gnu::always_inline]] static std::array<N, kFields> fields(const N (&floats)[kFields], const Frame& frame) {
    return shape_fields(floats, frame);
  }

  template <class N, class R, class V>
  [[gnu::always_inline]] static ShapeTest<N, R> test(const R& ray, const V& fields) {
    return {ray, fields};
  }
};

static_assert(MixedPrimitive<Shapes>);

}  // namespace fastlines
