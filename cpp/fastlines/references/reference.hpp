// A reference: a primitive as a node sees it. One primitive can have many references.
#pragma once

#include <cstdint>
#include <limits>

#include "../memory/buffer.hpp"
#include "../primitives/primitive.hpp"

namespace fastlines {

/// What a tree keeps. For curves, [s0, s1) is the piece that the reference stands for; the pieces of a primitive
/// tile it without gap or overlap, and the last one is open to +∞. A whole primitive is [0, ∞).
struct Reference {
  std::uint32_t prim;
  float s0 = 0.0f;
  float s1 = std::numeric_limits<float>::infinity();
};
static_assert(sizeof(Reference) == 12);

/// What a builder moves about: a reference and the box of its piece.
struct BuildRef {
  Reference ref;
  Box box;

  double centre(int axis) const { return double(box.lo[axis]) + double(box.hi[axis]); }
};

}  // namespace fastlines
