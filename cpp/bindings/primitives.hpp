// Primitives of a kind that is known at run time only.
#pragma once

#include <stdexcept>
#include <string>

#include "arrays.hpp"
#include "fastlines/primitives/boxes.hpp"
#include "fastlines/primitives/segments.hpp"
#include "fastlines/primitives/triangles.hpp"

namespace fastlines {

/// Call use(prims) with the set of primitives of this kind.
template <class Use>
auto with_primitives(const std::string& kind, const Input<float>& data, Use&& use) {
  if (kind == "segments") return use(Segments{rows<Segment>(data)});
  if (kind == "triangles") return use(Triangles{rows<Triangle>(data)});
  if (kind == "boxes") return use(Boxes{rows<Box>(data)});
  throw std::invalid_argument("unknown kind of primitive: " + kind);
}

}  // namespace fastlines
