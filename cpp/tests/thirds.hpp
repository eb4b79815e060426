// Two planes, at one and two thirds of the longest side of the node's box.
#pragma once

#include "fastlines/splits/candidate.hpp"

namespace fastlines {

struct Thirds {
  static constexpr bool kTightOnly = false;  // planes suit both kinds of boxes

  template <Primitives P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, CandidateVisitor visitor) const {
    const int axis = box.longest_axis();
    for (const double share : {1.0 / 3.0, 2.0 / 3.0}) {
      const float plane = float(box.lo[axis] + share * (double(box.hi[axis]) - double(box.lo[axis])));
      if (plane <= box.lo[axis] || plane >= box.hi[axis]) continue;
      const Candidate split = evaluate_plane(prims, refs, box, rule, axis, plane);
      if (divides(split, rule)) visitor(split);
    }
  }
};
static_assert(CandidateSet<Thirds>);

}  // namespace fastlines
