// The measure of candidates: areas of boxes and numbers of tests.
#pragma once

#include "../math/box.hpp"

namespace fastlines {

/// The areas and counts by which candidates are compared.
struct Measure {
  double margin = 0.0;    ///< boxes are grown by this much on all sides
  std::size_t lanes = 1;  ///< references tested at once; a power of two

  double area(const Box& box) const { return box.area(margin); }

  /// The number of tests that `n_refs` references count as: the mean of n_refs and n_refs rounded up to full lanes.
  double tests(std::size_t n_refs) const {
    return 0.5 * (double(n_refs) + double((n_refs + lanes - 1) & ~(lanes - 1)));
  }
};

}  // namespace fastlines
