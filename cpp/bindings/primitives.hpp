// Sets of primitives whose kind is only known at run time.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>

#include "arrays.hpp"
#include "fastlines/primitives/boxes.hpp"
#include "fastlines/primitives/segment_test.hpp"
#include "fastlines/primitives/triangles.hpp"

namespace fastlines {

/// The primitives that the engines are compiled for, the fast path. To compile them for another one, add it here.
using RayPrimitives = std::variant<Segments>;

/// The set of primitives of a kind, if the engines are compiled for it. The set points into `data`.
inline std::optional<RayPrimitives> find_ray_primitives(const std::string& kind, const Input<float>& data) {
  std::optional<RayPrimitives> found;
  [&]<class... P>(std::type_identity<std::variant<P...>>) {
    ((kind == P::kKind ? void(found = P{rows<typename P::Item>(data)}) : void()), ...);
  }(std::type_identity<RayPrimitives>());
  return found;
}

inline RayPrimitives ray_primitives(const std::string& kind, const Input<float>& data) {
  if (const auto found = find_ray_primitives(kind, data)) return *found;
  throw std::invalid_argument("the engines are not compiled for this kind of primitive: " + kind);
}

/// Calls use(prims) with the set of primitives of any kind.
template <class Use>
auto with_primitives(const std::string& kind, const Input<float>& data, Use&& use) {
  if (const auto found = find_ray_primitives(kind, data)) return std::visit(use, *found);
  if (kind == "triangles") return use(Triangles{rows<Triangle>(data)});
  if (kind == "boxes") return use(Boxes{rows<Box>(data)});
  throw std::invalid_argument("unknown kind of primitive: " + kind);
}

}  // namespace fastlines
