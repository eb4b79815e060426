// A reference: one entry of a leaf's list. One primitive can have many references, one for each of its pieces.
#pragma once

#include <cstdint>

#include "../math/vec.hpp"

namespace fastlines {

/// A reference as trees store it. For curves, [s0, s1) is its piece. The pieces of a primitive tile it without gap or
/// overlap, and the last piece extends to +∞. A whole primitive is [0, ∞).
struct Reference {
  std::uint32_t prim;
  float s0 = 0.0f;
  float s1 = kInfinity;
};
static_assert(sizeof(Reference) == 12);

}  // namespace fastlines
