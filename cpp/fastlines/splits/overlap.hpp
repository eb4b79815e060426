// The overlap of the children of a split: the criterion of SBVH for spatial splits (Stich, Friedrich, Dietrich 2009,
// "Spatial splits in bounding volume hierarchies").
#pragma once

#include "candidate.hpp"

namespace fastlines {

/// The area in which the two children of the best uncut split overlap. Spatial splits are considered only where it is
/// large.
class Overlap {
 public:
  /// Consider an uncut split.
  void add(const Candidate& split, const Measure& measure = {}) {
    const double sah = split.sah(measure);
    if (sah >= least_sah_) return;
    least_sah_ = sah;
    Box both;
    for (int k = 0; k < 3; ++k) {
      both.lo[k] = std::max(split.left.lo[k], split.right.lo[k]);
      both.hi[k] = std::min(split.left.hi[k], split.right.hi[k]);
    }
    area_ = measure.area(both);
  }

  /// The area of the overlap; ∞ if there was no candidate.
  double area() const { return area_; }

 private:
  double least_sah_ = kInfinity, area_ = kInfinity;
};

}  // namespace fastlines
