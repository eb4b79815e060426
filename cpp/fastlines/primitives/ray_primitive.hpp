// What the fast path asks of a primitive, besides what builders ask (primitive.hpp).
//
// Leaves of the layout hold the axis of a primitive, a straight line from end to end, and cull by its distance from the
// ray. The exact test decides; it reads a primitive as a few numbers, its lanes, in the frame of the scene.
#pragma once

#include <array>
#include <concepts>
#include <cstring>
#include <type_traits>

#include "../simd/float_x16.hpp"
#include "segments.hpp"

namespace fastlines {

/// Where t is taken: at the closest approach, or where the ray enters the surface.
enum class At { closest, surface };

/// Where a ray comes nearest to a primitive, or enters its surface: at t in the frame, next to the axis' point at s.
template <class N>
struct ClosestApproach {
  N s, t, dist2;
  MaskOf<N> hit;  // whether it comes within its radius
};

/// The numbers that the exact test of P reads, each of one primitive (N = float) or of 16 (N = FloatX16).
template <class P, class N>
using Lanes = std::array<N, P::kLanes>;

template <class P>
concept RayPrimitive = Curves<P> && requires(const P& prims, const typename P::Item& item, std::uint32_t prim) {
  /// Plain data of one primitive, a multiple of four bytes: what the caller's array holds in a row.
  requires std::is_trivially_copyable_v<typename P::Item>;
  /// The name of the kind, as Python and the bindings call it.
  { P::kKind } -> std::convertible_to<const char*>;
  /// How many lanes the exact test reads.
  { P::kLanes } -> std::convertible_to<int>;
  /// Whether primitives have a radius of their own. Without it, all that concerns radii is compiled away.
  { P::kHasRadius } -> std::convertible_to<bool>;
  /// A primitive, by id.
  { prims.item(prim) } -> std::same_as<const typename P::Item&>;
  /// All of them in a row.
  { prims.items() } -> std::same_as<const typename P::Item*>;
  /// The line from end to end.
  { P::axis(item) } -> std::same_as<const Segment&>;
  /// The largest radius along the axis, in the units of the scene.
  { P::radius(item) } -> std::same_as<float>;
  /// The largest radius of all, in the units of the scene.
  { prims.max_radius() } -> std::same_as<float>;
  /// And three templates. `P::lanes(floats, frame)` brings the floats of an item, or those of 16, into the frame; the
  /// first six lanes are the start of the axis, and its end − start. `P::lane_radius(lanes)` is the largest radius
  /// along the axis, in the frame. `P::test<N>(ray, lanes)` is the exact test: an object with `closest`, `entry()`,
  /// `exit()`.
};

/// The lanes of one primitive.
template <RayPrimitive P, class Frame>
[[gnu::always_inline]] inline Lanes<P, float> lanes_of(const typename P::Item& item, const Frame& frame) {
  float floats[sizeof(item) / sizeof(float)];
  std::memcpy(floats, &item, sizeof item);
  return P::lanes(floats, frame);
}

/// The exact test of P, where t is taken as asked. Every answer comes from here.
template <At at, class Test>
[[gnu::always_inline]] inline decltype(auto) approach_at(const Test& test) {
  if constexpr (at == At::surface)
    return test.entry();
  else
    return (test.closest);
}

}  // namespace fastlines
