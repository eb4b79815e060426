// The ends of a piece of a segment and the box around them, four lanes at a time: the floats that Segment::point gives.
#pragma once

#include "../primitives/segments.hpp"
#include "../references/reference.hpp"
#include "../simd/four.hpp"

namespace fastlines {

/// Points in the first three lanes; what is in the last means nothing.
struct Ends {
  Float4 a, c;
};

[[gnu::always_inline]] inline Ends ends_of(const Segment& segment, const Reference& ref) {
  const Float4 p = four(&segment.p[0]), tail = four(&segment.p[2]);
  const Float4 q = __builtin_shufflevector(tail, tail, 1, 2, 3, 3);
  double both;  // s0 and s1 as they stand, moved at once
  std::memcpy(&both, &ref.s0, sizeof both);
  const Float4 s = Float4(Double2{both, 0.0});
  Double4 from, along, wide;
  to_double(p, from);
  to_double(q, along);
  to_double(s, wide);
  along -= from;
  const Double4 a = from + __builtin_shufflevector(wide, wide, 0, 0, 0, 0) * along;
  const Double4 c = from + __builtin_shufflevector(wide, wide, 1, 1, 1, 1) * along;
  return {__builtin_shufflevector(s, s, 0, 0, 0, 0) < four(1.0f) ? __builtin_convertvector(a, Float4) : q,
          __builtin_shufflevector(s, s, 1, 1, 1, 1) < four(1.0f) ? __builtin_convertvector(c, Float4) : q};
}

/// A box in two registers.
struct Box4 {
  Float4 lo, hi;

  static Box4 empty() {
    const Float4 infinity = four(std::numeric_limits<float>::infinity());
    return {infinity, -infinity};
  }
  static Box4 around(const Ends& ends) { return {min(ends.a, ends.c), max(ends.a, ends.c)}; }

  [[gnu::always_inline]] void grow(const Box4& other) {
    lo = min(lo, other.lo);
    hi = max(hi, other.hi);
  }

  bool is_empty() const { return lo[0] > hi[0]; }
};

}  // namespace fastlines
