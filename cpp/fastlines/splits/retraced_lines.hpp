// Retraced lines: lines that run along each other, such as the streamlines of a circling flow. Each cut across them
// halves their boxes, so it always looks profitable. But each line has a part on both sides, and a ray that hits one
// line hits all, so cuts do not pay.
#pragma once

#include <cmath>
#include <type_traits>

#include "candidate.hpp"

namespace fastlines {

/// Constants of the test for retraced lines; `fastlines-bench study retraced` measures its effect.
struct RetracedTuning {
  /// A plane is tested if at least this fraction of a node's references straddle it. Of a bundle of evenly
  /// spaced pieces, 0.3 stops BVHs just before nodes of two references each; uncut splits do the rest.
  double tight_share = 0.3;
  /// The same for KD trees, which have no uncut splits and can only continue with planes.
  double cut_share = 0.5;
  /// About this many references of a node are sampled: more are more accurate, but take longer.
  std::size_t n_sampled = 128;
};

/// The spread of curves where they cross a plane x[axis] = plane: the root mean square distance from their mean. Only
/// the distance perpendicular to the first curve counts, so that a plane that runs along the curves does not widen it.
template <Curve C>
class Spread {
 public:
  Spread(int axis, float plane) : axis_(axis), plane_(plane) {}

  /// Add a curve that crosses the plane.
  void add(const C& curve) {
    const Vec3 at = curve.point(curve.crossing(axis_, plane_));
    if (n_++ == 0) set_first(curve, at);
    double offset[3], along = 0.0;
    for (int k = 0; k < 3; ++k) {
      offset[k] = double(at[k]) - first_[k];
      along += offset[k] * direction_[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double across = offset[k] - along * direction_[k];
      sum_[k] += across;
      squares_ += across * across;
    }
  }

  /// Whether the spread is at most `distance`; true if there are no curves.
  bool within(double distance) const {
    if (n_ == 0) return true;
    double sum2 = 0.0;
    for (const double sum : sum_) sum2 += sum * sum;
    return squares_ - sum2 / double(n_) <= double(n_) * distance * distance;
  }

 private:
  void set_first(const C& curve, const Vec3& at) {
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

/// Whether a split cuts retraced lines: a plane that a large share of the references straddle, if their spread is at
/// most `distance`. The spread is measured at the plane and halfway to either end of the box, because lines that cross
/// in one point lie apart elsewhere. Large nodes are sampled.
template <Primitives P>
bool cuts_retraced(const P& prims, Refs refs, const Box& box, BoxRule rule, const Candidate& split, double distance) {
  if constexpr (Curves<P>) {
    constexpr RetracedTuning tuning{};
    const double min_share = rule == BoxRule::tight ? tuning.tight_share : tuning.cut_share;
    if (split.kind != Candidate::Kind::plane || distance == 0.0) return false;
    const std::size_t n_both = split.n_left + split.n_right - refs.size();
    if (n_both < 2 || double(n_both) < min_share * double(refs.size())) return false;
    const std::size_t step = std::max<std::size_t>(1, refs.size() / tuning.n_sampled);
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
