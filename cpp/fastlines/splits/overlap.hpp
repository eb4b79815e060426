// The criterion of SBVH for spatial splits.
#pragma once

#include "candidate.hpp"

namespace fastlines {

/// The area of the overlap of the two children of the best uncut split. SBVH considers spatial splits only where that
/// area is large (Stich, Friedrich, Dietrich 2009, "Spatial splits in bounding volume hierarchies").
class Overlap {
 public:
  /// Add a candidate.
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
  static constexpr double kInf = std::numeric_limits<double>::infinity();
  double least_sah_ = kInf, area_ = kInf;
};

}  // namespace fastlines
