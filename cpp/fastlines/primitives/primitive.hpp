// What the builder needs from a set of primitives: their number, their boxes, and the box of the part of a primitive
// that lies in a given box. Anything with these three functions can be put into a tree.
//
// A set of curves over a parameter s in [0, 1] can do more: it gives the s at which a curve crosses a plane. Its
// references then know their piece [s0, s1), cut exactly (see references/cut.hpp).
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "../math/box.hpp"

namespace fastlines {

/// A set of primitives, for builders.
template <class P>
concept Primitives = requires(const P& prims, std::uint32_t prim, const Box& box) {
  /// The number of primitives.
  { prims.size() } -> std::convertible_to<std::size_t>;
  /// The box of a primitive.
  { prims.bounds(prim) } -> std::same_as<Box>;
  /// The box of the part of a primitive that lies in `box`; empty if there is none.
  { prims.clipped_bounds(prim, box) } -> std::same_as<Box>;
};

/// A curve whose coordinates are monotonic in s.
template <class C>
concept Curve = requires(const C& curve, int axis, float plane, float s) {
  /// The s at which the curve crosses the plane x[axis] = plane.
  { curve.crossing(axis, plane) } -> std::same_as<float>;
  /// The point at s.
  { curve.point(s) } -> std::same_as<Vec3>;
  /// Whether x[axis] grows with s.
  { curve.ascends(axis) } -> std::same_as<bool>;
};

/// A set of curves.
template <class P>
concept Curves = Primitives<P> && requires(const P& prims, std::uint32_t prim) {
  { prims.curve(prim) } -> Curve;
};

/// The box that bounds all primitives; empty if there are none.
template <Primitives P>
Box bounds_of_all(const P& prims) {
  Box box = Box::empty();
  for (std::size_t prim = 0; prim < prims.size(); ++prim) box.grow(prims.bounds(std::uint32_t(prim)));
  return box;
}

}  // namespace fastlines
