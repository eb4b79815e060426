// The frame of a scene: coordinates relative to its centre, scaled by a power of two into [−1, 1]³.
//
// All queries, brute force too, compute in this frame. So an answer does not depend on the tree, and its precision does
// not depend on the scene's size or place. The subtraction is rounded once; the scaling is exact.
#pragma once

#include "../math/vec.hpp"

namespace fastlines {

struct Frame {
  Vec3 centre{0, 0, 0};
  float scale = 1.0f;  ///< a power of two
  /// How far a hit can lie outside the grown box of its leaf, in the frame: twice the slack, and the rounding that
  /// grows with the radius of a primitive.
  float overhang = 0.0f;

  /// A point in the frame.
  Vec3 operator()(const Vec3& point) const { return (point - centre) * scale; }
};

}  // namespace fastlines
