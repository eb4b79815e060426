// What queries need from a primitive, in addition to what builders need (primitive.hpp).
//
// There are two kinds. A primitive around an axis is a line with a radius: a capsule, or a shape inside one. Leaves of
// the layout store its axis, the straight line from end to end, and are culled by the distance of the axis from the
// ray. Leaves of all other primitives store boxes, as nodes do.
//
// The exact test decides. It reads a primitive as a few numbers, its fields, in the frame of the scene. Kernels test 16
// primitives at once, each field in a vector of 16 lanes (SoA).
//
// What kernels call for each test is [[gnu::always_inline]], so that its vectors stay in registers. The answers are the
// same without.
#pragma once

#include <array>
#include <concepts>
#include <cstring>
#include <type_traits>

#include "../simd/float_x16.hpp"
#include "closest_approach.hpp"
#include "ray_view.hpp"
#include "segments.hpp"

namespace fastlines {

/// The fields of a primitive (N = float) or of 16 (N = FloatX16): the numbers that the exact test of P reads.
template <class P, class N>
using Fields = std::array<N, P::kFields>;

/// A set of primitives for the fast path. The bindings construct it as P{std::span<const Item>}.
///
/// Two members are templates, which a concept cannot name:
/// - `P::fields(floats, frame)` returns the `Fields` in the frame. `floats` is the item as an array of sizeof(Item) / 4
///   numbers, in the order of its members.
/// - `P::test<N>(ray, fields)` returns the exact test, an object with `closest`, `entry()` and `exit()`. Its
///   `enters(entry)` says whether a ray that hits comes in from outside. The ray is a `RayView` of N.
///
/// The radius of a query counts as the exact test counts it. A hit must lie within that radius of the primitive's box.
template <class P>
concept RayPrimitive = Primitives<P> && requires(const P& prims, const typename P::Item& item, std::uint32_t prim) {
  /// Plain data of one primitive: float members only, as in a row of the caller's array.
  requires std::is_trivially_copyable_v<typename P::Item> && sizeof(typename P::Item) % sizeof(float) == 0;
  /// The name of the kind in Python and in the bindings.
  { P::kKind } -> std::convertible_to<const char*>;
  /// The number of fields that the exact test reads.
  requires P::kFields >= 6;
  /// A primitive, by id.
  { prims.item(prim) } -> std::same_as<const typename P::Item&>;
  /// All primitives, as an array.
  { prims.items() } -> std::same_as<const typename P::Item*>;
};

/// A set of primitives around axes. Trees are over the axes; queries add the radii.
///
/// The first six fields are the start of the axis and its end − start. `P::frame_radius(fields)` returns the largest
/// radius along the axis, in the frame.
template <class P>
concept AxisPrimitive = RayPrimitive<P> && Straight<P> && requires(const P& prims, const typename P::Item& item) {
  /// Whether primitives have a radius of their own. If not, the code for radii is compiled away.
  { P::kHasRadius } -> std::convertible_to<bool>;
  /// The line from end to end. `curve` of `Straight` returns the same.
  { P::axis(item) } -> std::same_as<const Segment&>;
  /// The largest radius along the axis, in units of the scene.
  { P::radius(item) } -> std::same_as<float>;
  /// The largest radius of all primitives, in units of the scene. Called for every ray, so it must not search.
  { prims.max_radius() } -> std::same_as<float>;
};

/// A set in which some primitives have an axis. Leaves of these alone store axes, as those of an `AxisPrimitive` do.
/// Unlike there, boxes include the radii.
template <class P>
concept MixedPrimitive = RayPrimitive<P> && requires(const typename P::Item& item) {
  /// Whether a primitive is a line with a radius around it.
  { P::has_axis(item) } -> std::same_as<bool>;
  { P::axis(item) } -> std::same_as<const Segment&>;
  { P::radius(item) } -> std::same_as<float>;
};

/// Whether leaves must be culled by the radius of their primitives.
template <RayPrimitive P>
inline constexpr bool kHasRadius = [] {
  if constexpr (AxisPrimitive<P>)
    return bool(P::kHasRadius);
  else
    return MixedPrimitive<P>;
}();

/// By how much a search has to grow the boxes of a tree, besides the radius of the query, in units of the scene.
template <RayPrimitive P>
float max_radius_of(const P& prims) {
  if constexpr (AxisPrimitive<P>)
    return prims.max_radius();
  else
    return 0.0f;
}

/// The fields of one primitive.
template <RayPrimitive P, class Frame>
[[gnu::always_inline]] inline Fields<P, float> fields_of(const typename P::Item& item, const Frame& frame) {
  float floats[sizeof(item) / sizeof(float)];
  std::memcpy(floats, &item, sizeof item);
  return P::fields(floats, frame);
}

static_assert(AxisPrimitive<Segments>);

}  // namespace fastlines
