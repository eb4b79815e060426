// What the builder asks of a set of primitives: how many, their boxes, and the box of the part of one that
// lies in a given box. Anything that answers these three can be put into a tree.
//
// A set of curves over a parameter s in [0, 1] may say more: at which s a primitive crosses a plane. Its
// references then know the piece [s0, s1] that they stand for, cut exactly (see references/cut.hpp).
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "../math/box.hpp"

namespace fastlines {

template <class P>
concept Primitives = requires(const P& prims, std::uint32_t prim, const Box& box) {
  { prims.size() } -> std::convertible_to<std::size_t>;
  { prims.bounds(prim) } -> std::same_as<Box>;
  { prims.clipped_bounds(prim, box) } -> std::same_as<Box>;
};

template <class C>
concept Curve = requires(const C& curve, int axis, float plane, float s) {
  { curve.crossing(axis, plane) } -> std::same_as<float>;
  { curve.point(s) } -> std::same_as<Vec3>;
  { curve.ascends(axis) } -> std::same_as<bool>;
};

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
