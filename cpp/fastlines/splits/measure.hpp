// How the search measures boxes and counts tests.
#pragma once

#include "../math/box.hpp"

namespace fastlines {

/// How the children of candidates are measured, where they are compared.
struct Measure {
  double margin = 0.0;    ///< boxes are grown by this much
  std::size_t lanes = 1;  ///< a power of two: references are tested so many at once

  double area(const Box& box) const { return box.area(margin); }

  /// How many tests so many references count as: half of them full lanes.
  double tests(std::size_t n_refs) const {
    return 0.5 * (double(n_refs) + double((n_refs + lanes - 1) & ~(lanes - 1)));
  }
};

}  // namespace fastlines
