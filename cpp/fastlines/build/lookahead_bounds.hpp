// Lower bounds on the costs of a node's children, computed before any candidate is applied: the bounds of branch and
// bound.
//
// A grid over a child has the planes of its parent's grid, except across the axis of the cut. So the parent can count,
// for each pair of planes across two axes, how many references of one plane's child lie on either side of the other
// plane. The only uncertain references are those that straddle both planes: the child holds only a part of each, which
// lies on at least one side. Across the axis of the cut, two neighbouring planes of the parent bound the counts on
// either side of any plane between them.
#pragma once

#include <array>
#include <cassert>
#include <cstring>
#include <vector>

#include "../simd/float_x8.hpp"
#include "../splits/candidate.hpp"

namespace fastlines {

/// The planes of a grid over a node, the counts of references for each pair of planes, and the bounds that follow.
/// Call `reset`, `add` for each plane, `compute`, then `lower_bounds`.
class LookaheadBounds {
 public:
  /// Start a new node. Boxes are measured with `margin` added on all sides.
  void reset(const Box& box, double margin) {
    box_ = box;
    scale_ = float(std::min(1.0 / box.side(box.longest_axis()), 1e38));
    margin_ = float(2 * margin) * scale_;
    for (Axis& axis : axes_) axis.planes.clear();
  }

  /// Add a plane; the planes of each axis must come in ascending order. Returns the index of the plane on its axis.
  std::size_t add(const Candidate& split) {
    std::vector<float>& planes = axes_[std::size_t(split.axis)].planes;
    planes.push_back(split.plane);
    return planes.size() - 1;
  }

  /// Compute the bounds, once all planes are added. Children are cut once more, or twice if `two_cuts`. `step` is the
  /// cost of a traversal step, in tests (c_trav / c_prim); it matters only for two cuts.
  void compute(Refs refs, bool two_cuts, double step) {
    n_refs_ = float(refs.size());
    two_cuts_ = two_cuts;
    step_ = float(step);
    for (int axis = 0; axis < 3; ++axis) axes_[std::size_t(axis)].reset(box_, axis, scale_, margin_);
    const auto& [x, y, z] = axes_;
    pairs_[0].reset(x, y);
    pairs_[1].reset(y, z);
    pairs_[2].reset(z, x);
    for (const BuildRef& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) axes_[std::size_t(axis)].add(ref.box, axis);
      pairs_[0].add(x, y);
      pairs_[1].add(y, z);
      pairs_[2].add(z, x);
    }
    bound_pair(pairs_[0], axes_[0], axes_[1], z.length);
    bound_pair(pairs_[1], axes_[1], axes_[2], x.length);
    bound_pair(pairs_[2], axes_[2], axes_[0], y.length);
    bound_axis(axes_[0], y.length, z.length);
    bound_axis(axes_[1], z.length, x.length);
    bound_axis(axes_[2], x.length, y.length);
  }

  /// Lower bounds for the left and the right child of a plane: the cost beyond one traversal step, in tests, times the
  /// child's area as a fraction of the node's.
  std::pair<double, double> lower_bounds(int axis, std::size_t plane) const {
    const Axis& of = axes_[std::size_t(axis)];
    const float x = axes_[0].length, y = axes_[1].length, z = axes_[2].length, area = x * y + x * z + y * z;
    if (!(area > 1e-30f)) return {0.0, 0.0};  // too thin for float32
    // Subtract a bound on the rounding. It grows with the number of planes: one of many planes may cut off little, but
    // the rounding is that of the whole box.
    const double per_area = (1 - 1e-6 * double(of.planes.size() + 16)) / double(area);
    return {per_area * double(of.least_left[plane]), per_area * double(of.least_right[plane])};
  }

 private:
  /// Load 8 floats from any address.
  [[gnu::always_inline]] static FloatX8 load(const float* from) {
    FloatX8 eight;
    std::memcpy(&eight, from, sizeof eight);
    return eight;
  }
  [[gnu::always_inline]] static void store(float* to, const FloatX8& eight) { std::memcpy(to, &eight, sizeof eight); }
  [[gnu::always_inline]] static FloatX8 one_where(const IntX8& mask) {
    return FloatX8(mask & IntX8(broadcast_x8(1.0f)));
  }

  /// The planes across an axis, and how the last reference added lies relative to each of them.
  struct Axis {
    std::vector<float> planes;
    std::vector<FloatX8> at;               // positions of the planes; unused lanes hold the upper side of the box
    std::vector<FloatX8> left, right;      // scaled lengths of the sides of a plane, with margin; ∞ in unused lanes
    float length;                          // scaled length of the box, with margin
    std::vector<FloatX8> n_left, n_right;  // references on either side of each plane
    std::vector<FloatX8> on_left, on_right, on_both;  // 1 or 0; a reference that only touches a plane may be on both
    std::size_t n_right_of;                           // planes that have the reference only on their right
    std::size_t n_before_hi;                          // planes below its upper side
    std::size_t n_before_lo;                          // planes below its lower side
    std::vector<float> least_left, least_right;       // bounds: tests times half an area

    std::size_t n_vectors() const { return at.size(); }

    void reset(const Box& box, int axis, float scale, float margin) {
      const std::size_t n = (planes.size() + 7) / 8;
      const float lo = box.lo[axis], hi = box.hi[axis];
      at.assign(n, broadcast_x8(hi));
      for (std::size_t i = 0; i < planes.size(); ++i) at[i / 8][i % 8] = planes[i];
      left.assign(n, broadcast_x8(kInfinity));
      right.assign(n, broadcast_x8(kInfinity));
      for (std::size_t i = 0; i < planes.size(); ++i) {
        left[i / 8][i % 8] = (planes[i] - lo) * scale + margin;
        right[i / 8][i % 8] = (hi - planes[i]) * scale + margin;
      }
      length = (hi - lo) * scale + margin;
      n_left.assign(n, FloatX8{});
      n_right.assign(n, FloatX8{});
      for (auto* lanes : {&on_left, &on_right, &on_both}) lanes->resize(n);
      for (auto* least : {&least_left, &least_right}) least->assign(8 * n, kInfinity);
    }

    /// Add a reference.
    [[gnu::always_inline]] void add(const Box& box, int axis) {
      n_right_of = n_before_hi = n_before_lo = 0;
      const float lo = box.lo[axis], hi = box.hi[axis];
      for (std::size_t i = 0; i < at.size(); ++i) {
        const IntX8 right_of = at[i] < hi, only_right = right_of & (at[i] <= lo), below = at[i] < lo;
        n_right_of += count_set(only_right);
        n_before_hi += count_set(right_of);
        n_before_lo += count_set(below);
        on_left[i] = one_where(~only_right);
        on_right[i] = one_where(right_of);
        on_both[i] = one_where(right_of & ~below);
        n_left[i] += on_left[i];
        n_right[i] += on_right[i];
      }
    }
  };

  /// Counts for all pairs of a plane across one axis (rows) and a plane across another (lanes). They count references
  /// on the left or right of both planes, and references that straddle both.
  struct PairCounts {
    std::vector<FloatX8> left_left, left_right, right_left, right_right, both;

    void reset(const Axis& rows, const Axis& lanes) {
      const std::size_t n = (rows.planes.size() + 1) * lanes.n_vectors();
      for (auto* table : {&left_left, &left_right, &right_left, &right_right, &both}) table->assign(n, FloatX8{});
    }

    /// Count the last reference of both axes. It is added only to the row where its range of rows begins or ends.
    [[gnu::always_inline]] void add(const Axis& rows, const Axis& lanes) {
      const std::size_t n = lanes.n_vectors();
      assert(rows.n_before_hi <= rows.planes.size());  // nothing reaches beyond the box
      for (std::size_t i = 0; i < n; ++i) {
        left_left[rows.n_right_of * n + i] += lanes.on_left[i];
        left_right[rows.n_right_of * n + i] += lanes.on_right[i];
        right_left[rows.n_before_hi * n + i] += lanes.on_left[i];
        right_right[rows.n_before_hi * n + i] += lanes.on_right[i];
        both[rows.n_before_lo * n + i] += lanes.on_both[i];
        both[rows.n_before_hi * n + i] -= lanes.on_both[i];
      }
    }

    /// Turn the entries into counts by prefix sums over the rows.
    void accumulate(const Axis& rows, const Axis& lanes) {
      const std::size_t n = lanes.n_vectors(), n_rows = rows.planes.size();
      for (std::size_t i = n; i < n_rows * n; ++i) {
        left_left[i] += left_left[i - n];
        left_right[i] += left_right[i - n];
        both[i] += both[i - n];
      }
      for (std::size_t i = n_rows * n; i-- > 0;) {
        right_left[i] += right_left[i + n];
        right_right[i] += right_right[i + n];
      }
    }
  };

  /// A part of a child: a lower bound on its cost, in tests times half its area, and what each further reference adds
  /// to that.
  struct ChildPart {
    FloatX8 cost, per_ref;
  };

  /// The part of sides x, y, z with n references, as a leaf. With two cuts, the part may be cut once more. Then each
  /// reference is in one of its halves. Both halves have the face of the cut twice, so half their area is no less than
  /// the area of the smallest face.
  [[gnu::always_inline]] ChildPart part(const FloatX8& x, const FloatX8& y, const FloatX8& z, const FloatX8& n) const {
    const FloatX8 xy = x * y, xz = x * z, yz = y * z, area = xy + xz + yz;
    const FloatX8 per_ref = two_cuts_ ? min(xy, min(xz, yz)) : area;
    return {min(area * n, area * step_ + per_ref * n), per_ref};
  }

  /// A bound for two parts together, and n references of which each is in at least one part.
  [[gnu::always_inline]] static FloatX8 bound_of_parts(const ChildPart& one, const ChildPart& other, const FloatX8& n) {
    return one.cost + other.cost + n * min(one.per_ref, other.per_ref);
  }

  /// Bound the children of each plane across one axis, when a plane across the other axis cuts them. `third` is the
  /// scaled length of the box along the remaining axis.
  void bound_pair(PairCounts& pair, Axis& rows, Axis& lanes, float third) const {
    pair.accumulate(rows, lanes);
    const std::size_t n = lanes.n_vectors(), n_rows = rows.planes.size();
    const FloatX8 side = broadcast_x8(third);
    for (std::size_t row = 0; row < n_rows; ++row) {
      const FloatX8 low = broadcast_x8(rows.left[row / 8][row % 8]), high = broadcast_x8(rows.right[row / 8][row % 8]);
      FloatX8 least_low = broadcast_x8(kInfinity), least_high = least_low;
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t at = row * n + i;
        const FloatX8 both = pair.both[at];
        const ChildPart ll = part(lanes.left[i], low, side, pair.left_left[at] - both),
                        lr = part(lanes.right[i], low, side, pair.left_right[at] - both),
                        rl = part(lanes.left[i], high, side, pair.right_left[at + n] - both),
                        rr = part(lanes.right[i], high, side, pair.right_right[at + n] - both);
        least_low = min(bound_of_parts(ll, lr, both), least_low);
        least_high = min(bound_of_parts(rl, rr, both), least_high);
        store(&lanes.least_left[8 * i], min(bound_of_parts(ll, rl, both), load(&lanes.least_left[8 * i])));
        store(&lanes.least_right[8 * i], min(bound_of_parts(lr, rr, both), load(&lanes.least_right[8 * i])));
      }
      rows.least_left[row] = std::min(rows.least_left[row], reduce_min(least_low));
      rows.least_right[row] = std::min(rows.least_right[row], reduce_min(least_high));
    }
  }

  /// Bound the children of each plane across an axis, when a plane across the same axis cuts them. `y` and `z` are the
  /// scaled lengths of the box along the other axes.
  void bound_axis(Axis& axis, float y, float z) {
    // List the edges from one end of the box to the other: their positions, and the counts on their left and right.
    const std::size_t n = axis.planes.size();
    edges_.assign(n + 10, axis.length - margin_);
    n_left_.assign(n + 10, n_refs_);
    n_right_.assign(n + 10, 0.0f);
    edges_[0] = n_left_[0] = 0.0f;
    n_right_[0] = n_refs_;
    for (std::size_t i = 0; i < n; ++i) {
      edges_[i + 1] = axis.left[i / 8][i % 8] - margin_;
      n_left_[i + 1] = axis.n_left[i / 8][i % 8];
      n_right_[i + 1] = axis.n_right[i / 8][i % 8];
    }
    const FloatX8 lane = {0, 1, 2, 3, 4, 5, 6, 7};
    for (std::size_t plane = 1; plane <= n; ++plane) {
      // Eight gaps between neighbouring edges a and b. Of the child's references, n_left_[a] are certain to be left of
      // a plane in the gap, and n_right_[b] right of it; references outside the child are subtracted from both. The
      // bound is concave in the plane's position, so it is smallest at a or at b.
      const auto between = [&](std::size_t gap, float begin, float end, float n_child, float n_beyond_left,
                               float n_beyond_right) __attribute__((always_inline)) {
        const FloatX8 n_left = load(&n_left_[gap]) - n_beyond_left, n_right = load(&n_right_[gap + 1]) - n_beyond_right;
        const FloatX8 n_rest = max(n_child - n_left - n_right, FloatX8{});
        FloatX8 least = broadcast_x8(kInfinity);
        for (const std::size_t edge : {gap, gap + 1}) {
          const FloatX8 at = load(&edges_[edge]);
          least = min(bound_of_parts(part(at - begin + margin_, broadcast_x8(y), broadcast_x8(z), n_left),
                                     part(end - at + margin_, broadcast_x8(y), broadcast_x8(z), n_right), n_rest),
                      least);
        }
        return least;
      };
      const float at = edges_[plane];
      FloatX8 least_low = broadcast_x8(kInfinity), least_high = least_low;
      for (std::size_t gap = 0; gap < plane; gap += 8) {
        const FloatX8 least = between(gap, 0.0f, at, n_left_[plane], 0.0f, n_refs_ - n_left_[plane]);
        least_low = min(lane + float(gap) < float(plane) ? least : broadcast_x8(kInfinity), least_low);
      }
      for (std::size_t gap = plane; gap <= n; gap += 8) {
        const FloatX8 least = between(gap, at, edges_[n + 1], n_right_[plane], n_refs_ - n_right_[plane], 0.0f);
        least_high = min(lane + float(gap) < float(n + 1) ? least : broadcast_x8(kInfinity), least_high);
      }
      axis.least_left[plane - 1] = std::min(axis.least_left[plane - 1], reduce_min(least_low));
      axis.least_right[plane - 1] = std::min(axis.least_right[plane - 1], reduce_min(least_high));
    }
  }

  Box box_;
  float scale_;   // 1 / the longest side of the box
  float margin_;  // twice the margin, scaled
  float n_refs_, step_;
  bool two_cuts_;
  std::array<Axis, 3> axes_;
  std::array<PairCounts, 3> pairs_;
  std::vector<float> edges_, n_left_, n_right_;  // scaled positions of the edges, and the counts on their sides
};

}  // namespace fastlines
