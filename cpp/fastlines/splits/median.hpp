// Median split (thesis §1.4.1): order the references by box centre on each axis, split at the median, and take the axis
// with the least sum of the children's areas. With cut boxes the plane passes through the median centre.
#pragma once

#include <optional>

#include "candidate.hpp"

namespace fastlines {

struct Median {
  static constexpr bool kTightOnly = false;

  template <Primitives P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, CandidateVisitor visitor) const {
    std::optional<Candidate> best;
    for (int axis = 0; axis < 3; ++axis) {
      const auto split = rule == BoxRule::tight ? at_object(refs, axis) : at_plane(prims, refs, box, axis);
      if (split && (!best || area_of(*split) < area_of(*best))) best = split;
    }
    if (best) visitor(*best);
  }

 private:
  static double area_of(const Candidate& split) { return split.left.area() + split.right.area(); }

  static std::optional<Candidate> at_object(Refs refs, int axis) {
    const std::size_t n_left = refs.size() / 2;
    if (n_left == 0) return {};
    std::vector<BuildRef> sorted(refs.begin(), refs.end());
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(n_left), sorted.end(), ByCentre{axis});
    const Refs all = sorted;
    return Candidate{Candidate::Kind::objects, axis, 0.0f, n_left, refs.size() - n_left, hull(all.first(n_left)),
                     hull(all.subspan(n_left))};
  }

  template <Primitives P>
  static std::optional<Candidate> at_plane(const P& prims, Refs refs, const Box& box, int axis) {
    if (refs.empty()) return {};
    std::vector<double> centres;  // times two
    for (const BuildRef& ref : refs) centres.push_back(ref.twice_centre(axis));
    const auto middle = centres.begin() + std::ptrdiff_t(centres.size() / 2);
    std::nth_element(centres.begin(), middle, centres.end());
    const float plane = float(*middle / 2);
    if (plane <= box.lo[axis] || plane >= box.hi[axis]) return {};
    return evaluate_plane(prims, refs, box, BoxRule::cut, axis, plane);
  }
};

}  // namespace fastlines
