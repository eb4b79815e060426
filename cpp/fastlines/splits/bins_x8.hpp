// The planes of a regular grid over a node's box, 8 at a time with one per lane, and the bins between them.
//
// Each plane counts the references on either side of it. The two ends of a piece grow the bounds of their bins, which
// the comparisons with the planes determine. Each plane keeps the bounds of the points where pieces cross it. The
// bounds of one side of a plane are then those of the bins there and of the plane's crossings. No branch depends on a
// piece, so each takes the same time.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "../primitives/segments.hpp"
#include "../simd/box_x4.hpp"
#include "../simd/float_x8.hpp"
#include "candidate.hpp"

namespace fastlines {

/// The planes of all three axes, and the bins between them. Memory is reused from node to node. For each node, call
/// `place`, then one of `count`, `add_uncut` and `add_piece` for all references, then `visit`.
class BinsX8 {
 public:
  /// Place the planes, and clear all counts and bounds. Unused lanes hold a plane at ∞.
  void place(const Box& box, int n_planes, BoxRule rule) {
    n_planes_ = std::size_t(n_planes);
    n_vectors_ = (n_planes_ + 7) / 8;
    planes_.resize(3 * n_vectors_);
    for_each_axis([&]<int axis>(Planes* planes, BoxX4*) {
      const float lo = box.lo[axis], step = float(box.side(axis) / (n_planes + 1));
      FloatX8 index = {1, 2, 3, 4, 5, 6, 7, 8};
      for (std::size_t i = 0; i < n_vectors_; ++i, index += 8.0f)
        planes[i].reset(index <= float(n_planes) ? lo + index * step : broadcast_x8(kInfinity));
    });
    if (rule != BoxRule::tight) return;
    for (Planes& planes : planes_) planes.reset_crossings();
    bins_.assign(3 * (8 * n_vectors_ + 1), BoxX4::empty());
  }

  /// Count a reference on the sides that `side_of` gives; for cut boxes.
  void count(const Box& box) {
    for_each_axis([&]<int axis>(Planes* planes, BoxX4*) {
      for (std::size_t i = 0; i < n_vectors_; ++i) {
        const IntX8 on_right = planes[i].at < box.hi[axis];
        planes[i].n_left -= (planes[i].at > box.lo[axis]) | ~on_right;
        planes[i].n_right -= on_right;
      }
    });
  }

  /// Add an uncut reference, on the side of its centre.
  [[gnu::always_inline]] void add_uncut(const Box& box) {
    const BoxX4 bounds = BoxX4::load(box);
    for_each_axis([&]<int axis>(Planes* planes, BoxX4* bins) __attribute__((always_inline)) {
      std::size_t bin = 0;
      for (std::size_t i = 0; i < n_vectors_; ++i) {
        const IntX8 on_right = planes[i].at <= centre_of(box, axis);
        planes[i].n_left += on_right + 1;
        planes[i].n_right -= on_right;
        bin += count_set(on_right);
      }
      bins[bin].grow(bounds);
    });
  }

  /// Add a piece, cut by the planes. Its ends are corners of its box.
  [[gnu::always_inline]] void add_piece(const Segment& segment, const Box& box) {
    // Order the corners of the box along the segment, for each axis.
    const BoxX4 bounds = BoxX4::load(box), ends = BoxX4::load(segment);
    const FloatX4 edge = ends.hi - ends.lo, inv_edge = 1.0f / edge;
    const IntX4 up = edge >= 0.0f;
    const FloatX4 from = up ? bounds.lo : bounds.hi, to = up ? bounds.hi : bounds.lo;
    for_each_axis([&]<int axis>(Planes* of_axis, BoxX4* bins) __attribute__((always_inline)) {
      const FloatX4 slope = edge * inv_edge[axis];
      std::size_t first = 0, last = 0;
      for (std::size_t i = 0; i < n_vectors_; ++i) {
        Planes& planes = of_axis[i];
        const IntX8 on_right = planes.at < box.hi[axis], only_right = on_right & (planes.at <= box.lo[axis]);
        planes.n_left += only_right + 1;
        planes.n_right -= on_right;
        first += count_set(only_right);
        last += count_set(on_right);
        const FloatX8 ahead = planes.at - from[axis];
        for (int j = 0; j < 2; ++j) {
          const int k = (axis + 1 + j) % 3;
          // NaN for planes that the piece does not cross: neither less nor greater than any number.
          const FloatX8 crossing = FloatX8(IntX8(from[k] + ahead * slope[k]) | only_right | ~on_right);
          planes.lo[j] = min(crossing, planes.lo[j]);
          planes.hi[j] = max(crossing, planes.hi[j]);
        }
      }
      // Grow the bins of both ends.
      const IntX4 rises = __builtin_shufflevector(up, up, axis, axis, axis, axis);
      bins[first].grow(rises ? from : to);
      bins[last].grow(rises ? to : from);
    });
  }

  /// Pass the candidate with the least SAH of each axis to `visitor`, or all candidates if `all`. SAH is that of
  /// `measure`. Returns whether there was a candidate.
  bool visit(Candidate::Kind kind, const Box& box, BoxRule rule, const Measure& measure, bool all,
             CandidateVisitor visitor) {
    const bool tight = rule == BoxRule::tight;
    bool any_visited = false;
    const Weights weights(box, measure);
    if (!tight && !all) return visit_cheapest_halves(kind, box, weights, visitor);
    for_each_axis([&]<int axis>(const Planes* of_axis, BoxX4* bins) __attribute__((always_inline)) {
      float least = kInfinity;
      Candidate best;
      BoxX4 before = BoxX4::empty();
      if (tight) accumulate(bins);
      for (std::size_t i = 0; i < n_vectors_; ++i) {
        const Planes& planes = of_axis[i];
        Sides left, right;
        IntX8 divides = (planes.at > box.lo[axis]) & (planes.at < box.hi[axis]);
        FloatX8 weight;
        if (tight) {
          both_sides<axis>(box, planes, bins + 8 * i, after_.data() + 8 * i, before, left, right);
          divides &= (planes.n_left > 0) & (planes.n_right > 0);
          weight = weights.weigh(planes, left, right);
        } else {
          weight = weights.weigh_halves<axis>(planes, box);
        }
        weight = (divides & (weight < kInfinity)) ? weight : broadcast_x8(kInfinity);  // NaN counts as ∞
        const auto candidate = [&](std::size_t lane) {
          const auto [left_box, right_box] =
              tight ? std::pair(left.box(lane), right.box(lane)) : halves(box, axis, planes.at[lane]);
          return Candidate{
              kind,     axis,     planes.at[lane], std::size_t(planes.n_left[lane]), std::size_t(planes.n_right[lane]),
              left_box, right_box};
        };
        if (all) {
          for (std::size_t lane = 0; lane < 8; ++lane)
            if (weight[lane] < kInfinity) visitor(candidate(lane));
        }
        if (bits_of(weight < least) == 0) continue;
        const std::size_t lane = index_of_min(weight);
        least = weight[lane];
        if (!all) best = candidate(lane);
      }
      any_visited |= least < kInfinity;
      if (!all && least < kInfinity) visitor(best);
    });
    return any_visited;
  }

 private:
  /// Eight planes across an axis: their counts of references on either side, and the bounds of their crossings.
  struct Planes {
    FloatX8 at;
    IntX8 n_left, n_right;
    FloatX8 lo[2], hi[2];  // bounds of the crossings, in the next two axes (cyclically)

    [[gnu::always_inline]] void reset(const FloatX8& planes) {
      at = planes;
      n_left = n_right = IntX8{};
    }
    [[gnu::always_inline]] void reset_crossings() {
      lo[0] = lo[1] = broadcast_x8(kInfinity);
      hi[0] = hi[1] = broadcast_x8(-kInfinity);
    }
  };

  /// The bounds on one side of 8 planes.
  struct Sides {
    FloatX8 lo[3], hi[3];

    Box box(std::size_t lane) const {
      return {{lo[0][lane], lo[1][lane], lo[2][lane]}, {hi[0][lane], hi[1][lane], hi[2][lane]}};
    }
  };

  /// The SAH of 8 planes, up to a constant factor. Areas are relative to the square of the longest side, so that they
  /// neither overflow nor underflow in float32.
  struct Weights {
    float scale;         // 1 / the longest side
    float grown;         // twice the margin, scaled
    std::int32_t lanes;  // as in `Measure`

    Weights(const Box& box, const Measure& measure)
        : scale(float(std::min(1.0 / box.side(box.longest_axis()), 1e38))),
          grown(2 * float(measure.margin) * scale),
          lanes(std::int32_t(measure.lanes)) {}

    /// Twice `Measure::tests`.
    [[gnu::always_inline]] FloatX8 tests(const IntX8& n_refs) const {
      return __builtin_convertvector(n_refs, FloatX8) +
             __builtin_convertvector((n_refs + (lanes - 1)) & -lanes, FloatX8);
    }

    [[gnu::always_inline]] FloatX8 weigh(const Planes& planes, const Sides& left, const Sides& right) const {
      const auto half_area = [&](const Sides& sides) __attribute__((always_inline)) {
        const FloatX8 x = (sides.hi[0] - sides.lo[0]) * scale + grown, y = (sides.hi[1] - sides.lo[1]) * scale + grown,
                      z = (sides.hi[2] - sides.lo[2]) * scale + grown;
        return x * y + x * z + y * z;
      };
      return half_area(left) * tests(planes.n_left) + half_area(right) * tests(planes.n_right);
    }

    /// For cut boxes: the children are the halves of the box.
    template <int axis>
    [[gnu::always_inline]] FloatX8 weigh_halves(const Planes& planes, const Box& box) const {
      const float x = float(box.side((axis + 1) % 3)) * scale + grown,
                  y = float(box.side((axis + 2) % 3)) * scale + grown, flat = x * y + (x + y) * grown,
                  per_length = (x + y) * scale;
      return (flat + per_length * (planes.at - box.lo[axis])) * tests(planes.n_left) +
             (flat + per_length * (box.hi[axis] - planes.at)) * tests(planes.n_right);
    }
  };

  /// For cut boxes: the first of the cheapest planes of each axis. Which plane is cheapest is unpredictable, and a
  /// misprediction would dominate in small nodes, so no branch depends on it.
  bool visit_cheapest_halves(Candidate::Kind kind, const Box& box, const Weights& weights, CandidateVisitor visitor) {
    bool any_visited = false;
    for_each_axis([&]<int axis>(const Planes* of_axis, const BoxX4*) __attribute__((always_inline)) {
      // Unused lanes weigh NaN. If the box is too thin for floats, planes may lie in its sides.
      const bool inside = of_axis[0].at[0] > box.lo[axis] && last_of(of_axis) < box.hi[axis];
      FloatX8 least = broadcast_x8(kInfinity);
      IntX8 vector{};  // the index of the vector that holds it
      for (std::size_t i = 0; i < n_vectors_; ++i) {
        const Planes& planes = of_axis[i];
        const FloatX8 weight = weights.weigh_halves<axis>(planes, box);
        IntX8 less = weight < least;
        if (!inside) less &= (planes.at > box.lo[axis]) & (planes.at < box.hi[axis]);
        least = less ? weight : least;
        vector = less ? IntX8{} + std::int32_t(i) : vector;
      }
      // Of equally cheap planes take the first.
      std::size_t lane = index_of_min(least);
      if (!(least[lane] < kInfinity)) return;
      for (unsigned ties = bits_of(least == least[lane]) & (~1u << lane); ties; ties &= ties - 1) {
        const auto tie = std::size_t(std::countr_zero(ties));
        if (vector[tie] < vector[lane]) lane = tie;
      }
      const Planes& planes = of_axis[vector[lane]];
      const float at = planes.at[lane];
      Candidate split{kind, axis, at, std::size_t(planes.n_left[lane]), std::size_t(planes.n_right[lane]), box, box};
      split.left.hi[axis] = split.right.lo[axis] = at;
      visitor(split);
      any_visited = true;
    });
    return any_visited;
  }

  /// Compute the bounds of each bin and all bins after it.
  void accumulate(const BoxX4* bins) {
    BoxX4 after = BoxX4::empty();
    after_.resize(8 * n_vectors_ + 1);
    for (std::size_t i = 8 * n_vectors_ + 1; i-- > 0;) {
      after.grow(bins[i]);
      after_[i] = after;
    }
  }

  /// The bounds on either side of 8 planes: those of the bins and of the crossings. `before` holds the bounds of all
  /// bins before; it is updated.
  template <int axis>
  [[gnu::always_inline]] static void both_sides(const Box& box, const Planes& planes, const BoxX4* bins,
                                                const BoxX4* after, BoxX4& before, Sides& left, Sides& right) {
    FloatX4 left_lo[8], left_hi[8], right_lo[8], right_hi[8];
    for (int lane = 0; lane < 8; ++lane) {
      before.grow(bins[lane]);
      left_lo[lane] = before.lo;
      left_hi[lane] = before.hi;
      right_lo[lane] = after[lane + 1].lo;
      right_hi[lane] = after[lane + 1].hi;
    }
    transpose(left_lo, left.lo);
    transpose(left_hi, left.hi);
    transpose(right_lo, right.lo);
    transpose(right_hi, right.hi);
    const IntX8 crossed = planes.lo[0] <= planes.hi[0];
    left.hi[axis] = crossed ? planes.at : left.hi[axis];
    right.lo[axis] = crossed ? planes.at : right.lo[axis];
    for (int j = 0; j < 2; ++j) {
      const int k = (axis + 1 + j) % 3;
      const FloatX8 lo = max(planes.lo[j], broadcast_x8(box.lo[k])), hi = min(planes.hi[j], broadcast_x8(box.hi[k]));
      left.lo[k] = min(lo, left.lo[k]);
      left.hi[k] = max(hi, left.hi[k]);
      right.lo[k] = min(lo, right.lo[k]);
      right.hi[k] = max(hi, right.hi[k]);
    }
  }

  /// The last plane across an axis.
  float last_of(const Planes* of_axis) const { return of_axis[(n_planes_ - 1) / 8].at[(n_planes_ - 1) % 8]; }

  template <class Use>
  [[gnu::always_inline]] void for_each_axis(Use&& use) {
    const std::size_t n_bins = 8 * n_vectors_ + 1;
    use.template operator()<0>(planes_.data(), bins_.data());
    use.template operator()<1>(planes_.data() + n_vectors_, bins_.data() + n_bins);
    use.template operator()<2>(planes_.data() + 2 * n_vectors_, bins_.data() + 2 * n_bins);
  }

  std::size_t n_planes_, n_vectors_;  // planes per axis, and vectors of 8 planes
  std::vector<Planes> planes_;
  std::vector<BoxX4> bins_, after_;  // after_[i] bounds bin i of an axis and all bins after it
};

}  // namespace fastlines
