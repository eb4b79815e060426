// A sum of float32 numbers that does not depend on their order.
//
// Let n numbers be less than 2ᵉ, and n < 2ᵇ. Each is rounded to a multiple of q = 2^(e + b − 51). All partial sums are
// then multiples of q below 2⁵³·q, which float64 holds exactly. A number keeps its 24 bits if it is more than n·2⁻²⁵ of
// the largest one.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "../../simd/lanes.hpp"

namespace fastlines {

/// Sums up to n numbers whose absolute values are at most `largest`. If that is infinite, nothing is rounded.
class ExactSum {
 public:
  ExactSum(double largest, std::uint64_t n) {
    int exponent = 0;
    // Adding this number and subtracting it again rounds to multiples of its last bit, which is q.
    if (std::isfinite(largest)) {
      std::frexp(largest, &exponent);
      rounder_ = std::ldexp(1.5, exponent + std::bit_width(n) + 1);
    }
  }

  void add(const double (&x)[kLanes]) {
    for (int i = 0; i < kLanes; ++i) sums_[i] += (x[i] + rounder_) - rounder_;
  }

  double total() const {
    double total = 0.0;
    for (const double sum : sums_) total += sum;
    return total;
  }

 private:
  double rounder_ = 0.0;
  double sums_[kLanes] = {};
};

}  // namespace fastlines
