// Sixteen pieces of axes, one in each lane, in the frame of a query for pairs; and the cull of pairs of pieces.
//
// Ends come from the bytes of a leaf, so each is off by at most √3/2 = 0.866 quanta, and so is every point of a piece.
// The slack of 0.89 quanta also covers the rounding of the arithmetic here.
//
// Pieces of a block that have no part in the box of a leaf, grown by the reach, are left out first. Then a pair of
// pieces passes if their boxes come within the reach of each other, and so do their lines. With u and v along the
// pieces, w from one to the other, and n = u × v, lines do so if (w·n)² ≤ reach²·|n|². Where lines are nearly
// parallel, n is mostly rounding: |w·n| and reach·|n| are off by at most E = 4.3·2⁻²⁴·|u|·|v|·(|w| + reach) together,
// besides a fraction of the reach. If other rounding leaves a margin of the reach, lines within reach − margin have
//
//     (w·n)² ≤ ((reach − margin)·|n| + E)² ≤ reach²·|n|² + E²·(1 + reach/(2·margin)).
//
// So the test adds this bound, with bounds of |u|, |v| and |w| that hold for the whole leaf.
#pragma once

#include "../../layout/leaf_bytes.hpp"
#include "../../layout/wide_bvh.hpp"
#include "../../query/proximity/axis_set.hpp"

namespace fastlines {

/// The piece of a leaf that is in a lane: loads of pairs of bytes split even and odd ones within groups of four lanes.
constexpr int piece_of_lane(int lane) { return 2 * (lane >> 2) + (lane & 1) + ((lane & 2) << 2); }

/// For each number of pieces, the lanes of the first ones.
inline constexpr auto kLanesOfFirst = [] {
  std::array<std::uint32_t, kSimdWidth + 1> masks{};
  for (int n = 0; n <= kSimdWidth; ++n)
    for (int lane = 0; lane < kSimdWidth; ++lane)
      masks[std::size_t(n)] |= std::uint32_t(piece_of_lane(lane) < n) << lane;
  return masks;
}();

/// How coordinates in the frame of a tree become those in the frame of a query, which is no smaller.
struct FrameChange {
  float scale, offset[3];

  FrameChange(const Frame& from, const Frame& to) : scale(to.scale / from.scale) {
    for (int k = 0; k < 3; ++k) offset[k] = float((double(from.centre[k]) - double(to.centre[k])) * double(to.scale));
  }

  float coordinate(float x, int axis) const { return fma(x, scale, offset[axis]); }
  /// A size in quanta; large enough that its inverse is finite.
  float quantum(float size) const { return std::max(size * scale, 1e-30f); }
};

struct PieceBlock {
  FloatX16 p[3], q[3], low[3], high[3];  ///< the ends of the pieces, and their boxes
  std::uint32_t lanes;                   ///< those that hold a piece
  float slack;                           ///< how far a point of a piece may be from where it is stored
  float radius = 0.0f;                   ///< the largest one, if radii count

  /// The pieces of a leaf that stores axes.
  [[gnu::always_inline]] PieceBlock(const WideLeaf& leaf, const FrameChange& change)
      : lanes(kLanesOfFirst[leaf.n_refs]), slack(0.89f * change.quantum(leaf.scale)) {
    using F = FloatX16;
    const auto bytes = [&](int at) { return F::bytes(leaf.ends + at); };
    const F first[2] = {bytes(0), bytes(16)}, z[2] = {bytes(32), bytes(48)}, second[2] = {bytes(64), bytes(80)};
    const auto evens = [](const F(&pairs)[2]) { return F::shuffle<0, 2, 0, 2>(pairs[0], pairs[1]); };
    const auto odds = [](const F(&pairs)[2]) { return F::shuffle<1, 3, 1, 3>(pairs[0], pairs[1]); };
    const F quanta_p[3] = {evens(first), odds(first), evens(z)}, quanta_q[3] = {evens(second), odds(second), odds(z)};
    const F scale = change.quantum(leaf.scale);
    for (int k = 0; k < 3; ++k) {
      const F org = change.coordinate(leaf.org[k], k);
      p[k] = fma(quanta_p[k], scale, org);
      q[k] = fma(quanta_q[k], scale, org);
    }
    bound();
  }

  /// The n axes of a set from a row on, as whole pieces, in a frame.
  PieceBlock(const AxisSet& set, std::uint32_t first_row, std::uint32_t n, const Frame& frame)
      : lanes(kLanesOfFirst[n]), slack(0.0f) {
    const float* rows[kSimdWidth];
    for (int lane = 0; lane < kSimdWidth; ++lane)
      rows[lane] = set.row(first_row + std::min(std::uint32_t(piece_of_lane(lane)), n - 1));
    FloatX16 fields[kAxisFields];
    set.load<true>(rows, frame, fields);
    for (int k = 0; k < 3; ++k) {
      p[k] = fields[k];
      q[k] = fields[3 + k];
    }
    radius = reduce_max(max(fields[6], fields[7]));
    bound();
  }

 private:
  [[gnu::always_inline]] void bound() {
    for (int k = 0; k < 3; ++k) {
      low[k] = min(p[k], q[k]);
      high[k] = max(p[k], q[k]);
    }
  }
};

/// The pieces of a block, to be read one at a time.
struct PieceArrays {
  alignas(64) float p[3][kSimdWidth], u[3][kSimdWidth], low[3][kSimdWidth], high[3][kSimdWidth];

  explicit PieceArrays(const PieceBlock& block) {
    for (int k = 0; k < 3; ++k) {
      block.p[k].store(p[k]);
      (block.q[k] - block.p[k]).store(u[k]);
      block.low[k].store(low[k]);
      block.high[k].store(high[k]);
    }
  }
};

/// A box in the frame of a query.
struct SearchBox {
  float low[3], high[3];
};

/// The pieces of a block, to be clipped by boxes.
class PieceSlabs {
 public:
  explicit PieceSlabs(const PieceBlock& block) : block_(block) {
    for (int k = 0; k < 3; ++k) {
      const FloatX16 u = block.q[k] - block.p[k];
      inverse_[k] = blend(u < FloatX16(0.0f), FloatX16(-1.0f), FloatX16(1.0f)) / max(abs(u), FloatX16(1e-18f));
    }
  }

  /// The lanes whose pieces have a part in a box that is grown by `reach`.
  [[gnu::always_inline]] std::uint32_t near(const SearchBox& box, float reach) const {
    FloatX16 enter = 0.0f, leave = 1.0f;
    for (int k = 0; k < 3; ++k) {
      const FloatX16 at_low = (FloatX16(box.low[k] - reach) - block_.p[k]) * inverse_[k];
      const FloatX16 at_high = (FloatX16(box.high[k] + reach) - block_.p[k]) * inverse_[k];
      enter = max(min(at_low, at_high), enter);
      leave = min(max(at_low, at_high), leave);
    }
    return (enter <= leave).bits() & block_.lanes;
  }

 private:
  const PieceBlock& block_;
  FloatX16 inverse_[3];
};

/// The square of the reach of a pair of leaves, and a bound on the rounding of the test of lines.
struct PairReach {
  float reach2, rounding;
};

/// The lanes whose pieces may come within the reach of the piece in one lane of another block.
[[gnu::always_inline]] inline std::uint32_t near_piece(const PieceArrays& one, int lane, const PieceBlock& block,
                                                       const PairReach& reach) {
  using F = FloatX16;
  F gap2 = 0.0f;
  for (int k = 0; k < 3; ++k) {
    const F gap = max(max(block.low[k] - F(one.high[k][lane]), F(one.low[k][lane]) - block.high[k]), F(0.0f));
    gap2 = fma(gap, gap, gap2);
  }
  const std::uint32_t near = ~(F(reach.reach2) < gap2).bits() & block.lanes;
  if (near == 0) return 0;
  F u[3], v[3], w[3], n[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = one.u[k][lane];
    v[k] = block.q[k] - block.p[k];
    w[k] = block.p[k] - F(one.p[k][lane]);
  }
  n[0] = fnma(u[2], v[1], u[1] * v[2]);
  n[1] = fnma(u[0], v[2], u[2] * v[0]);
  n[2] = fnma(u[1], v[0], u[0] * v[1]);
  const F across = fma(w[0], n[0], fma(w[1], n[1], w[2] * n[2]));
  const F length2 = fma(n[0], n[0], fma(n[1], n[1], n[2] * n[2]));
  // A comparison with NaN passes.
  return near & ~(fma(length2, reach.reach2, reach.rounding) < across * across).bits();
}

}  // namespace fastlines
