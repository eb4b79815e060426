// All n − 1 splits of the uncut references, sorted by box centre, on each axis: the classic SAH of a BVH (thesis §1.5).
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct ObjectSweep {
  static constexpr bool kTightOnly = true;

  template <Primitives P>
  void visit(const P&, Refs refs, const Box&, BoxRule, CandidateVisitor visitor) const {
    const std::size_t n = refs.size();
    if (n < 2) return;
    std::vector<std::pair<double, std::uint32_t>> order(n);  // twice the centre, and index of the reference
    std::vector<Box> from(n);                                // from[i] bounds the references from i on
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < n; ++i) order[i] = {refs[i].twice_centre(axis), std::uint32_t(i)};
      std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : ByCentre{axis}(refs[a.second], refs[b.second]);
      });
      // Sweep from the right for the boxes of the right children, then from the left.
      Box box = Box::empty();
      for (std::size_t i = n; i-- > 0;) {
        box.grow(refs[order[i].second].box);
        from[i] = box;
      }
      box = Box::empty();
      for (std::size_t n_left = 1; n_left < n; ++n_left) {
        box.grow(refs[order[n_left - 1].second].box);
        visitor(Candidate{Candidate::Kind::objects, axis, 0.0f, n_left, n - n_left, box, from[n_left]});
      }
    }
  }
};

}  // namespace fastlines
