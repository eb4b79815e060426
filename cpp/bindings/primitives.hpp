// Sets of primitives whose kind is only known at run time.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "arrays.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/primitives/spread_cones.hpp"

namespace fastlines {

/// The primitives that layouts and queries are compiled for. To add one, include its header and list it here. Trees
/// over primitives around axes are trees over these axes, as segments.
using RayPrimitives = std::variant<Segments, RoundCones, Shapes>;

/// What queries are compiled for: the same, and what rays with a spread see of lines.
template <class... P>
std::variant<P..., SpreadCones> and_spread_cones(std::variant<P...>);
using QueryPrimitives = decltype(and_spread_cones(std::declval<RayPrimitives>()));

/// The primitives that trees are over, besides segments.
using OtherPrimitives = std::variant<Shapes>;

/// A set that points into `data`, which has one row of numbers for each primitive. The largest radius may be known.
template <class P>
P primitives_in(const Input<float>& data, std::optional<float> max_radius = {}) {
  constexpr std::size_t n_floats = sizeof(typename P::Item) / sizeof(float);
  if (data.ndim() != 2 || data.shape(1) != n_floats)
    throw std::invalid_argument(std::string(P::kKind) + " need rows of " + std::to_string(n_floats) + " numbers each");
  const auto items = rows<typename P::Item>(data);
  if constexpr (std::is_constructible_v<P, std::span<const typename P::Item>, float>)
    if (max_radius) return P(items, *max_radius);
  return P{items};
}

/// The set of primitives of a kind, if `Variant` lists it.
template <class Variant>
std::optional<Variant> find_primitives(const std::string& kind, const Input<float>& data,
                                       std::optional<float> max_radius = {}) {
  std::optional<Variant> found;
  [&]<class... P>(std::type_identity<std::variant<P...>>) {
    ((kind == P::kKind ? void(found = primitives_in<P>(data, max_radius)) : void()), ...);
  }(std::type_identity<Variant>());
  return found;
}

template <class Variant = RayPrimitives>
Variant ray_primitives(const std::string& kind, const Input<float>& data, std::optional<float> max_radius = {}) {
  if (const auto found = find_primitives<Variant>(kind, data, max_radius)) return *found;
  throw std::invalid_argument("the engines are not compiled for this kind of primitive: " + kind);
}

/// Calls use(prims) with the set of primitives that a tree is over.
template <class Use>
auto with_primitives(const std::string& kind, const Input<float>& data, Use&& use) {
  if (kind == Segments::kKind) return use(primitives_in<Segments>(data));
  if (const auto found = find_primitives<OtherPrimitives>(kind, data)) return std::visit(use, *found);
  throw std::invalid_argument("unknown kind of primitive: " + kind);
}

}  // namespace fastlines
