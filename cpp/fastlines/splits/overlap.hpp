// What SBVH decides by.
#pragma once

#include "candidate.hpp"

namespace fastlines {

/// The area in which the children of the best split into whole references overlap: SBVH asks for spatial splits only
/// where that is large (Stich, Friedrich, Dietrich 2009, "Spatial splits in bounding volume hierarchies").
class Overlap {
 public:
  void look_at(const Candidate& split, const Measure& measure = {}) {
    const double sah = split.sah(measure);
    if (sah >= least_) return;
    least_ = sah;
    Box both;
    for (int k = 0; k < 3; ++k) {
      both.lo[k] = std::max(split.left.lo[k], split.right.lo[k]);
      both.hi[k] = std::min(split.left.hi[k], split.right.hi[k]);
    }
    area_ = measure.area(both);
  }

  /// Infinite if there was none.
  double area() const { return area_; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double least_ = kNone, area_ = kNone;
};

}  // namespace fastlines
