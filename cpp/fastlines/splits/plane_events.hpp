// Planes through the sides of the references' boxes, where the cost of a KD split has its extrema (thesis §1.5). The
// outermost planes cut off empty space.
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct PlaneEvents {
  static constexpr bool kTightOnly = false;

  template <Primitives P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, CandidateVisitor visitor) const {
    const std::size_t n = refs.size();
    std::vector<float> los(n), his(n), flats, planes;
    for (int axis = 0; axis < 3; ++axis) {
      // Sort the sides.
      flats.clear();
      for (std::size_t i = 0; i < n; ++i) {
        los[i] = refs[i].box.lo[axis];
        his[i] = refs[i].box.hi[axis];
        if (los[i] == his[i]) flats.push_back(los[i]);
      }
      std::sort(los.begin(), los.end());
      std::sort(his.begin(), his.end());
      std::sort(flats.begin(), flats.end());
      planes.resize(2 * n);
      std::merge(los.begin(), los.end(), his.begin(), his.end(), planes.begin());
      planes.erase(std::unique(planes.begin(), planes.end()), planes.end());

      // A reference is left of a plane if it begins before the plane or lies in it; right if it ends beyond the plane.
      std::size_t n_begun = 0, n_ended = 0, n_flat = 0, n_flat_before = 0;
      for (const float plane : planes) {
        while (n_begun < n && los[n_begun] < plane) ++n_begun;
        while (n_ended < n && his[n_ended] <= plane) ++n_ended;
        n_flat_before = n_flat;
        while (n_flat < flats.size() && flats[n_flat] <= plane) ++n_flat;
        if (plane <= box.lo[axis] || plane >= box.hi[axis]) continue;
        if (rule == BoxRule::tight) {
          const Candidate split = evaluate_plane(prims, refs, box, rule, axis, plane);
          if (divides(split, rule)) visitor(split);
          continue;
        }
        const auto [left, right] = halves(box, axis, plane);
        visitor(Candidate{Candidate::Kind::plane, axis, plane, n_begun + (n_flat - n_flat_before), n - n_ended, left,
                          right});
      }
    }
  }
};

}  // namespace fastlines
