// Pieces of straight primitives, along their axes, as primitives of their own. A tree is over pieces if lines were cut
// before it was built (thesis §2.2), or if subtrees that hold pieces were moved.
//
// A node of such a tree lists pieces. Another piece of the same line may also lie in its box and be listed elsewhere.
#pragma once

#include <span>
#include <vector>

#include "../primitives/segments.hpp"
#include "reference.hpp"

namespace fastlines {

/// The piece of each reference, as a segment: a part of the axis.
template <Straight P>
std::vector<Segment> pieces_of(const P& prims, std::span<const Reference> refs) {
  std::vector<Segment> pieces;
  pieces.reserve(refs.size());
  for (const Reference& ref : refs) {
    const Segment& axis = prims.curve(ref.prim);
    pieces.push_back({axis.point(ref.s0), axis.point(std::min(ref.s1, 1.0f))});
  }
  return pieces;
}

/// One reference to each whole piece, in the order of the pieces.
inline std::vector<Reference> references_to(std::span<const Segment> pieces) {
  std::vector<Reference> refs(pieces.size());
  for (std::size_t i = 0; i < refs.size(); ++i) refs[i].prim = std::uint32_t(i);
  return refs;
}

}  // namespace fastlines
