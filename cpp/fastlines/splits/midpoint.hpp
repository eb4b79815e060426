// Spatial median (thesis §1.4.1): one plane at the midpoint of the longest side of the node's box.
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct Midpoint {
  static constexpr bool kTightOnly = false;

  template <Primitives P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, CandidateVisitor visitor) const {
    const int axis = box.longest_axis();
    const float plane = float(0.5 * (double(box.lo[axis]) + double(box.hi[axis])));
    if (plane <= box.lo[axis] || plane >= box.hi[axis]) return;
    const Candidate split = evaluate_plane(prims, refs, box, rule, axis, plane);
    if (divides(split, rule)) visitor(split);
  }
};

}  // namespace fastlines
