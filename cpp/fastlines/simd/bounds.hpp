// A box in four lanes, of which the last is anything: two instructions grow it.
#pragma once

#include <limits>

#include "../geometry/box.hpp"
#include "four.hpp"

namespace fastlines {

struct Bounds {
  Float4 lo = four(std::numeric_limits<float>::infinity()), hi = four(-std::numeric_limits<float>::infinity());

  Bounds() = default;

  /// Of two corners, one after the other in memory.
  template <class Corners>
  [[gnu::always_inline]] explicit Bounds(const Corners& corners) {
    static_assert(sizeof corners == 24);
    Float4 tail;
    std::memcpy(&lo, &corners, sizeof lo);
    std::memcpy(&tail, reinterpret_cast<const char*>(&corners) + 8, sizeof tail);
    hi = __builtin_shufflevector(tail, tail, 1, 2, 3, 3);
  }

  [[gnu::always_inline]] void grow(const Bounds& other) {
    lo = min(other.lo, lo);
    hi = max(other.hi, hi);
  }
  [[gnu::always_inline]] void grow(const Float4& point) {
    lo = min(point, lo);
    hi = max(point, hi);
  }

  Box box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
};

}  // namespace fastlines
