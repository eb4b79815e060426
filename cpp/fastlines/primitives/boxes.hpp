// Boxes as primitives: the least that a tree can be built over.
#pragma once

#include <span>

#include "primitive.hpp"

namespace fastlines {

/// Boxes as a set of primitives.
struct Boxes {
  using Item = Box;
  static constexpr const char* kKind = "boxes";

  std::span<const Box> data;

  std::size_t size() const { return data.size(); }
  Box bounds(std::uint32_t prim) const { return data[prim]; }

  Box clipped_bounds(std::uint32_t prim, const Box& box) const {
    Box both = data[prim];
    for (int k = 0; k < 3; ++k) {
      both.lo[k] = std::max(both.lo[k], box.lo[k]);
      both.hi[k] = std::min(both.hi[k], box.hi[k]);
    }
    return both.is_empty() ? Box::empty() : both;
  }
};
static_assert(Primitives<Boxes>);

}  // namespace fastlines
