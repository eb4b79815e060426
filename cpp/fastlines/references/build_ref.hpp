// A reference as builders move it.
#pragma once

#include "../memory/buffer.hpp"
#include "../primitives/primitive.hpp"
#include "reference.hpp"

namespace fastlines {

/// A reference with the box of its piece.
struct BuildRef {
  Reference ref;
  Box box;

  /// Twice the centre of the box.
  double twice_centre(int axis) const { return double(box.lo[axis]) + double(box.hi[axis]); }
};

}  // namespace fastlines
