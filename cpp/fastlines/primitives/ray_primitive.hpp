// What queries need from a primitive, in addition to what builders need (primitive.hpp).
//
// Leaves of the layout store the axis of a primitive, the straight line from end to end, and are culled by the distance
// of the axis from the ray. The exact test decides. It reads a primitive as a few numbers, its lanes, in the frame of
// the scene.
#pragma once

#include <array>
#include <concepts>
#include <cstring>
#include <type_traits>

#include "../simd/float_x16.hpp"
#include "segments.hpp"

namespace fastlines {

/// The point at which t is taken: the closest approach, or where the ray enters the surface.
enum class At { closest, surface };

/// The closest approach of a ray to a primitive, or its entry: t in the frame, and s of the nearest point of the axis.
template <class N>
struct ClosestApproach {
  N s, t, dist2;
  MaskOf<N> hit;  ///< whether the ray comes within its radius
};

/// The numbers that the exact test of P reads: those of one primitive (N = float) or of 16 (N = FloatX16).
template <class P, class N>
using Lanes = std::array<N, P::kLanes>;

template <class P>
concept RayPrimitive = Curves<P> && requires(const P& prims, const typename P::Item& item, std::uint32_t prim) {
  /// Plain data of one primitive, a multiple of 4 bytes; the element of the caller's array.
  requires std::is_trivially_copyable_v<typename P::Item>;
  /// The name of the kind in Python and in the bindings.
  { P::kKind } -> std::convertible_to<const char*>;
  /// The number of lanes that the exact test reads.
  { P::kLanes } -> std::convertible_to<int>;
  /// Whether primitives have a radius of their own. If not, the code for radii is compiled away.
  { P::kHasRadius } -> std::convertible_to<bool>;
  /// A primitive, by id.
  { prims.item(prim) } -> std::same_as<const typename P::Item&>;
  /// All primitives, as an array.
  { prims.items() } -> std::same_as<const typename P::Item*>;
  /// The line from end to end.
  { P::axis(item) } -> std::same_as<const Segment&>;
  /// The largest radius along the axis, in units of the scene.
  { P::radius(item) } -> std::same_as<float>;
  /// The largest radius of all primitives, in units of the scene.
  { prims.max_radius() } -> std::same_as<float>;
  /// Three templates, which a concept cannot name:
  /// - `P::lanes(floats, frame)`: the floats of an item, or those of 16, in the frame. The first six lanes are the
  /// start
  ///   of the axis and its end − start.
  /// - `P::lane_radius(lanes)`: the largest radius along the axis, in the frame.
  /// - `P::test<N>(ray, lanes)`: the exact test, an object with `closest`, `entry()` and `exit()`.
};

/// The lanes of one primitive.
template <RayPrimitive P, class Frame>
[[gnu::always_inline]] inline Lanes<P, float> lanes_of(const typename P::Item& item, const Frame& frame) {
  float floats[sizeof(item) / sizeof(float)];
  std::memcpy(floats, &item, sizeof item);
  return P::lanes(floats, frame);
}

/// The approach of an exact test, with t at the point that `at` names. Every answer comes from here.
template <At at, class Test>
[[gnu::always_inline]] inline decltype(auto) approach_at(const Test& test) {
  if constexpr (at == At::surface)
    return test.entry();
  else
    return (test.closest);
}

}  // namespace fastlines
