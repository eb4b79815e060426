// All n − 1 cuts of the whole references, sorted by box centre, on each axis: classic SAH for a BVH (§1.5).
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct ObjectSweep {
  template <Primitives P, class Visitor>
  void visit(const P&, Refs refs, const Box&, BoxRule, Visitor&& visitor) const {
    const std::size_t n = refs.size();
    if (n < 2) return;
    std::vector<BuildRef> sorted(refs.begin(), refs.end());
    std::vector<Box> from(n);  // from[i] bounds sorted[i ..]
    for (int axis = 0; axis < 3; ++axis) {
      std::sort(sorted.begin(), sorted.end(), ByCentre{axis});
      Box box = Box::empty();
      for (std::size_t i = n; i-- > 0;) {
        box.grow(sorted[i].box);
        from[i] = box;
      }
      box = Box::empty();
      for (std::size_t n_left = 1; n_left < n; ++n_left) {
        box.grow(sorted[n_left - 1].box);
        visitor(Candidate{Candidate::Kind::objects, axis, 0.0f, n_left, n - n_left, box, from[n_left]});
      }
    }
  }
};

}  // namespace fastlines
