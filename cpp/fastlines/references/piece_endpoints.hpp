// The ends of a piece of a segment and the box around them, in four lanes. The floats are those of `Segment::point`.
#pragma once

#include "../primitives/segments.hpp"
#include "../simd/box_x4.hpp"
#include "reference.hpp"

namespace fastlines {

/// The points at s0 and s1 in lanes 0 to 2; lane 3 is undefined.
struct PieceEndpoints {
  FloatX4 a, c;  ///< as in kernels/intersect/leaf_cull.hpp: w = c − a
};

/// The ends of a piece.
[[gnu::always_inline]] inline PieceEndpoints endpoints_of(const Segment& segment, const Reference& ref) {
  const FloatX4 p = load_x4(&segment.p[0]), tail = load_x4(&segment.p[2]);
  const FloatX4 q = __builtin_shufflevector(tail, tail, 1, 2, 3, 3);
  double both;  // the bits of s0 and s1, loaded at once
  std::memcpy(&both, &ref.s0, sizeof both);
  const FloatX4 s = FloatX4(DoubleX2{both, 0.0});
  DoubleX4 from, along, wide;
  to_double(p, from);
  to_double(q, along);
  to_double(s, wide);
  along -= from;
  const DoubleX4 a = from + __builtin_shufflevector(wide, wide, 0, 0, 0, 0) * along;
  const DoubleX4 c = from + __builtin_shufflevector(wide, wide, 1, 1, 1, 1) * along;
  return {__builtin_shufflevector(s, s, 0, 0, 0, 0) < broadcast_x4(1.0f) ? __builtin_convertvector(a, FloatX4) : q,
          __builtin_shufflevector(s, s, 1, 1, 1, 1) < broadcast_x4(1.0f) ? __builtin_convertvector(c, FloatX4) : q};
}

/// The box around both ends.
[[gnu::always_inline]] inline BoxX4 box_of(const PieceEndpoints& ends) { return BoxX4::around(ends.a, ends.c); }

}  // namespace fastlines
