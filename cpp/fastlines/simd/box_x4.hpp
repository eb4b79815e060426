// A box as two vectors of four lanes, which two instructions grow. Lane 3 is padding.
#pragma once

#include "../math/box.hpp"
#include "float_x4.hpp"

namespace fastlines {

struct BoxX4 {
  FloatX4 lo, hi;

  static BoxX4 empty() {
    const FloatX4 infinity = broadcast_x4(kInfinity);
    return {infinity, -infinity};
  }
  /// The box of two points.
  static BoxX4 around(const FloatX4& a, const FloatX4& b) { return {min(a, b), max(a, b)}; }

  /// Loads two points that lie next to each other in memory: the corners of a box, or the ends of a segment. Ends go to
  /// lo and hi in their order; `around` sorts them.
  template <class Corners>
  [[gnu::always_inline]] static BoxX4 load(const Corners& corners) {
    static_assert(sizeof corners == 24);
    BoxX4 box;
    FloatX4 tail;
    std::memcpy(&box.lo, &corners, sizeof box.lo);
    std::memcpy(&tail, reinterpret_cast<const char*>(&corners) + 8, sizeof tail);
    box.hi = __builtin_shufflevector(tail, tail, 1, 2, 3, 3);
    return box;
  }

  [[gnu::always_inline]] void grow(const BoxX4& other) {
    lo = min(other.lo, lo);
    hi = max(other.hi, hi);
  }
  [[gnu::always_inline]] void grow(const FloatX4& point) {
    lo = min(point, lo);
    hi = max(point, hi);
  }

  bool is_empty() const { return lo[0] > hi[0]; }
  Box box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
};

}  // namespace fastlines
