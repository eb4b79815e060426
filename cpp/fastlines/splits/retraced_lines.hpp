// Lines that run along each other, as those of a flow that circles. Each cut across them halves their boxes, so it
// always looks worth it; but all of them are on both sides, and a ray that meets one meets all. No cut parts them.
#pragma once

#include <cmath>
#include <type_traits>

#include "candidate.hpp"

namespace fastlines {

/// How far curves lie from their middle where they cross a plane x[axis] = plane: the root mean square, measured across
/// the first of them, so that a plane that runs along them spreads them no wider.
template <Curve C>
class Spread {
 public:
  Spread(int axis, float plane) : axis_(axis), plane_(plane) {}

  void add(const C& curve) {
    const Vec3 at = curve.point(curve.crossing(axis_, plane_));
    if (n_++ == 0) begin(curve, at);
    double away[3], along = 0.0;
    for (int k = 0; k < 3; ++k) {
      away[k] = double(at[k]) - first_[k];
      along += away[k] * direction_[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double across = away[k] - along * direction_[k];
      sum_[k] += across;
      squares_ += across * across;
    }
  }

  /// Whether they lie no farther away than this, as none do.
  bool within(double distance) const {
    if (n_ == 0) return true;
    double of_middle = 0.0;
    for (const double sum : sum_) of_middle += sum * sum;
    return squares_ - of_middle / double(n_) <= double(n_) * distance * distance;
  }

 private:
  void begin(const C& curve, const Vec3& at) {
    const Vec3 from = curve.point(0.0f), to = curve.point(1.0f);
    double squares = 0.0;
    for (int k = 0; k < 3; ++k) {
      first_[k] = at[k];
      direction_[k] = double(to[k]) - double(from[k]);
      squares += direction_[k] * direction_[k];
    }
    for (double& x : direction_) x /= std::sqrt(squares);
  }

  int axis_;
  float plane_;
  std::size_t n_ = 0;
  double first_[3], direction_[3], sum_[3] = {}, squares_ = 0.0;
};

/// Whether a plane leaves a large share of the references on both sides that lie within a distance of their middle: at
/// the plane and halfway to either end of the box, for lines that cross in one point part elsewhere. Some references
/// are looked at.
template <Primitives P>
bool cuts_retraced(const P& prims, Refs refs, const Box& box, BoxRule rule, const Candidate& split, double distance) {
  if constexpr (Curves<P>) {
    // Of a bundle of evenly spread pieces, 0.3 stops BVHs short of two references each; whole splits do the rest. A KD
    // tree has none, and can only go on with planes.
    const double share = rule == BoxRule::tight ? 0.3 : 0.5;
    constexpr std::size_t n_looked_at = 128;
    if (split.kind != Candidate::Kind::plane || distance == 0.0) return false;
    const std::size_t n_both = split.n_left + split.n_right - refs.size();
    if (n_both < 2 || double(n_both) < share * double(refs.size())) return false;
    const std::size_t step = std::max<std::size_t>(1, refs.size() / n_looked_at);
    const float lo = box.lo[split.axis], hi = box.hi[split.axis];
    for (const float plane : {split.plane, 0.5f * lo + 0.5f * split.plane, 0.5f * split.plane + 0.5f * hi}) {
      Spread<std::remove_cvref_t<decltype(prims.curve(0))>> spread(split.axis, plane);
      for (std::size_t i = 0; i < refs.size(); i += step)
        if (side_of(refs[i].box, split.axis, plane) == Side::both) spread.add(prims.curve(refs[i].ref.prim));
      if (!spread.within(distance)) return false;
    }
    return true;
  } else {
    return false;
  }
}

}  // namespace fastlines
