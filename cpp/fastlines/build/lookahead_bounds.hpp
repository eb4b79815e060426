// What the children of a node cost at least, before any is carried out: bounds for branch and bound (docs/theory.md,
// theorem 9).
//
// A grid has the same planes over a child as over its parent, but across the axis of the cut. So the parent can count,
// for each pair of planes across two axes, what the child of one plane will have on either side of the other. It is
// certain of all but the references that straddle both, of which the child sees only a part: those lie on one side at
// least. Across the axis of the cut, the planes of the parent tell how many lie at least on either side of whatever
// plane there is between two of them.
#pragma once

#include <array>
#include <cassert>
#include <cstring>
#include <vector>

#include "../simd/float_x8.hpp"
#include "../splits/candidate.hpp"

namespace fastlines {

/// The planes of a grid over a node, and what its references have to do with each two of them.
class LookaheadBounds {
 public:
  void begin(const Box& box, double margin) {
    box_ = box;
    scale_ = float(std::min(1.0 / box.side(box.longest_axis()), 1e38));
    margin_ = float(2 * margin) * scale_;
    for (Axis& axis : axes_) axis.planes.clear();
  }

  /// The planes of each axis have to rise. Returns the plane's number on its axis.
  std::size_t add(const Candidate& split) {
    std::vector<float>& planes = axes_[std::size_t(split.axis)].planes;
    planes.push_back(split.plane);
    return planes.size() - 1;
  }

  /// Once all planes are there. Children are cut once more, or twice; then what a step costs matters, in parts of what
  /// a test does.
  void count(Refs refs, bool twice, double step) {
    n_refs_ = float(refs.size());
    twice_ = twice;
    step_ = float(step);
    for (int axis = 0; axis < 3; ++axis) axes_[std::size_t(axis)].begin(box_, axis, scale_, margin_);
    const auto& [x, y, z] = axes_;
    pairs_[0].begin(x, y);
    pairs_[1].begin(y, z);
    pairs_[2].begin(z, x);
    for (const BuildRef& ref : refs) {
      for (int axis = 0; axis < 3; ++axis) axes_[std::size_t(axis)].add(ref.box, axis);
      pairs_[0].add(x, y);
      pairs_[1].add(y, z);
      pairs_[2].add(z, x);
    }
    bound_pair(pairs_[0], axes_[0], axes_[1], z.whole);
    bound_pair(pairs_[1], axes_[1], axes_[2], x.whole);
    bound_pair(pairs_[2], axes_[2], axes_[0], y.whole);
    bound_axis(axes_[0], y.whole, z.whole);
    bound_axis(axes_[1], z.whole, x.whole);
    bound_axis(axes_[2], x.whole, y.whole);
  }

  /// What the left and the right child of a plane cost at least beside a step, in tests, times their areas, in parts of
  /// the node's.
  std::pair<double, double> least(int axis, std::size_t plane) const {
    const Axis& of = axes_[std::size_t(axis)];
    const float x = axes_[0].whole, y = axes_[1].whole, z = axes_[2].whole, area = x * y + x * z + y * z;
    if (!(area > 1e-30f)) return {0.0, 0.0};  // too thin for float32
    // What roundings can add up to: where one plane of many cuts off little, that is little beside the whole.
    const double per_area = (1 - 1e-6 * double(of.planes.size() + 16)) / double(area);
    return {per_area * double(of.least_left[plane]), per_area * double(of.least_right[plane])};
  }

 private:
  /// Eight numbers, wherever they are.
  [[gnu::always_inline]] static FloatX8 load(const float* from) {
    FloatX8 eight;
    std::memcpy(&eight, from, sizeof eight);
    return eight;
  }
  [[gnu::always_inline]] static void store(float* to, const FloatX8& eight) { std::memcpy(to, &eight, sizeof eight); }
  [[gnu::always_inline]] static FloatX8 one_where(const IntX8& mask) { return FloatX8(mask & IntX8(eight(1.0f))); }
  [[gnu::always_inline]] static float reduce_min(FloatX8 x) {
    x = min(x, FloatX8(__builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3)));
    x = min(x, FloatX8(__builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5)));
    x = min(x, FloatX8(__builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6)));
    return x[0];
  }

  static constexpr float kInf = std::numeric_limits<float>::infinity();

  /// The planes across an axis, and what the last reference that was added has to do with them.
  struct Axis {
    std::vector<float> planes;
    std::vector<FloatX8> at;           // the planes, and in lanes that are left the upper side of the box
    std::vector<FloatX8> left, right;  // how long is what lies on either side, grown; ∞ in lanes that are left
    float whole;                       // how long the box is, grown
    std::vector<FloatX8> n_left, n_right;
    std::vector<FloatX8> on_left, on_right, on_both;  // 1 or 0; what only touches a plane may count as on both
    std::size_t n_behind, n_reached, n_below;         // planes that it is right of; reaches the right of; begins beyond
    std::vector<float> least_left, least_right;       // bounds: n times half an area

    std::size_t n_octets() const { return at.size(); }

    void begin(const Box& box, int axis, float scale, float margin) {
      const std::size_t n = (planes.size() + 7) / 8;
      const float lo = box.lo[axis], hi = box.hi[axis];
      at.assign(n, eight(hi));
      for (std::size_t i = 0; i < planes.size(); ++i) at[i / 8][i % 8] = planes[i];
      left.assign(n, eight(kInf));
      right.assign(n, eight(kInf));
      for (std::size_t i = 0; i < planes.size(); ++i) {
        left[i / 8][i % 8] = (planes[i] - lo) * scale + margin;
        right[i / 8][i % 8] = (hi - planes[i]) * scale + margin;
      }
      whole = (hi - lo) * scale + margin;
      n_left.assign(n, FloatX8{});
      n_right.assign(n, FloatX8{});
      for (auto* lanes : {&on_left, &on_right, &on_both}) lanes->resize(n);
      for (auto* least : {&least_left, &least_right}) least->assign(8 * n, kInf);
    }

    [[gnu::always_inline]] void add(const Box& box, int axis) {
      n_behind = n_reached = n_below = 0;
      const float lo = box.lo[axis], hi = box.hi[axis];
      for (std::size_t i = 0; i < at.size(); ++i) {
        const IntX8 right_of = at[i] < hi, behind = right_of & (at[i] <= lo), below = at[i] < lo;
        n_behind += count_set(behind);
        n_reached += count_set(right_of);
        n_below += count_set(below);
        on_left[i] = one_where(~behind);
        on_right[i] = one_where(right_of);
        on_both[i] = one_where(right_of & ~below);
        n_left[i] += on_left[i];
        n_right[i] += on_right[i];
      }
    }
  };

  /// For all pairs of a plane across one axis (rows) and one across another (lanes): how many references are on their
  /// left or right sides, and how many are on both sides of both.
  struct Pair {
    std::vector<FloatX8> left_left, left_right, right_left, right_right, both;

    void begin(const Axis& rows, const Axis& lanes) {
      const std::size_t n = (rows.planes.size() + 1) * lanes.n_octets();
      for (auto* table : {&left_left, &left_right, &right_left, &right_right, &both}) table->assign(n, FloatX8{});
    }

    /// Only in the row where that begins or ends.
    [[gnu::always_inline]] void add(const Axis& rows, const Axis& lanes) {
      const std::size_t n = lanes.n_octets();
      assert(rows.n_reached <= rows.planes.size());  // nothing reaches beyond the box
      for (std::size_t i = 0; i < n; ++i) {
        left_left[rows.n_behind * n + i] += lanes.on_left[i];
        left_right[rows.n_behind * n + i] += lanes.on_right[i];
        right_left[rows.n_reached * n + i] += lanes.on_left[i];
        right_right[rows.n_reached * n + i] += lanes.on_right[i];
        both[rows.n_below * n + i] += lanes.on_both[i];
        both[rows.n_reached * n + i] -= lanes.on_both[i];
      }
    }

    /// Add up.
    void finish(const Axis& rows, const Axis& lanes) {
      const std::size_t n = lanes.n_octets(), n_rows = rows.planes.size();
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

  /// A part of a child: what its references cost at least, times half its area, and what each more adds to it.
  struct ChildPart {
    FloatX8 cost, more;
  };

  /// As a leaf. Cut once more, each reference is in one of the halves, which have the face that is cut, and so no less
  /// than half the area of the smallest.
  [[gnu::always_inline]] ChildPart part(const FloatX8& x, const FloatX8& y, const FloatX8& z, const FloatX8& n) const {
    const FloatX8 xy = x * y, xz = x * z, yz = y * z, area = xy + xz + yz;
    const FloatX8 more = twice_ ? min(xy, min(xz, yz)) : area;
    return {min(area * n, area * step_ + more * n), more};
  }

  /// Two parts, and references of which each is in one of them at least.
  [[gnu::always_inline]] static FloatX8 together(const ChildPart& one, const ChildPart& other, const FloatX8& n) {
    return one.cost + other.cost + n * min(one.more, other.more);
  }

  /// The children of a plane across one axis, cut by one across the other.
  void bound_pair(Pair& pair, Axis& rows, Axis& lanes, float third) const {
    pair.finish(rows, lanes);
    const std::size_t n = lanes.n_octets(), n_rows = rows.planes.size();
    const FloatX8 side = eight(third);
    for (std::size_t row = 0; row < n_rows; ++row) {
      const FloatX8 low = eight(rows.left[row / 8][row % 8]), high = eight(rows.right[row / 8][row % 8]);
      FloatX8 least_low = eight(kInf), least_high = least_low;
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t at = row * n + i;
        const FloatX8 both = pair.both[at];
        const ChildPart ll = part(lanes.left[i], low, side, pair.left_left[at] - both),
                        lr = part(lanes.right[i], low, side, pair.left_right[at] - both),
                        rl = part(lanes.left[i], high, side, pair.right_left[at + n] - both),
                        rr = part(lanes.right[i], high, side, pair.right_right[at + n] - both);
        least_low = min(together(ll, lr, both), least_low);
        least_high = min(together(rl, rr, both), least_high);
        store(&lanes.least_left[8 * i], min(together(ll, rl, both), load(&lanes.least_left[8 * i])));
        store(&lanes.least_right[8 * i], min(together(lr, rr, both), load(&lanes.least_right[8 * i])));
      }
      rows.least_left[row] = std::min(rows.least_left[row], reduce_min(least_low));
      rows.least_right[row] = std::min(rows.least_right[row], reduce_min(least_high));
    }
  }

  /// The children of a plane, cut once more across the same axis.
  void bound_axis(Axis& axis, float y, float z) {
    // From one end of the box to the other: where planes are, and what is on their left and right.
    const std::size_t n = axis.planes.size();
    edges_.assign(n + 10, axis.whole - margin_);
    n_left_.assign(n + 10, n_refs_);
    n_right_.assign(n + 10, 0.0f);
    edges_[0] = n_left_[0] = 0.0f;
    n_right_[0] = n_refs_;
    for (std::size_t i = 0; i < n; ++i) {
      edges_[i + 1] = axis.left[i / 8][i % 8] - margin_;
      n_left_[i + 1] = axis.n_left[i / 8][i % 8];
      n_right_[i + 1] = axis.n_right[i / 8][i % 8];
    }
    const FloatX8 number = {0, 1, 2, 3, 4, 5, 6, 7};
    for (std::size_t plane = 1; plane <= n; ++plane) {
      // From a to b, of which n_left_[a] and n_right_[b] are sure to be on the left and the right, but for those
      // beyond.
      const auto between = [&](std::size_t gap, float begin, float end, float n_child, float n_below,
                               float n_above) __attribute__((always_inline)) {
        const FloatX8 n_left = load(&n_left_[gap]) - n_below, n_right = load(&n_right_[gap + 1]) - n_above;
        const FloatX8 n_rest = max(n_child - n_left - n_right, FloatX8{});
        FloatX8 least = eight(kInf);
        for (const std::size_t edge : {gap, gap + 1}) {
          const FloatX8 at = load(&edges_[edge]);
          least = min(together(part(at - begin + margin_, eight(y), eight(z), n_left),
                               part(end - at + margin_, eight(y), eight(z), n_right), n_rest),
                      least);
        }
        return least;
      };
      const float at = edges_[plane];
      FloatX8 least_low = eight(kInf), least_high = least_low;
      for (std::size_t gap = 0; gap < plane; gap += 8) {
        const FloatX8 least = between(gap, 0.0f, at, n_left_[plane], 0.0f, n_refs_ - n_left_[plane]);
        least_low = min(number + float(gap) < float(plane) ? least : eight(kInf), least_low);
      }
      for (std::size_t gap = plane; gap <= n; gap += 8) {
        const FloatX8 least = between(gap, at, edges_[n + 1], n_right_[plane], n_refs_ - n_right_[plane], 0.0f);
        least_high = min(number + float(gap) < float(n + 1) ? least : eight(kInf), least_high);
      }
      axis.least_left[plane - 1] = std::min(axis.least_left[plane - 1], reduce_min(least_low));
      axis.least_right[plane - 1] = std::min(axis.least_right[plane - 1], reduce_min(least_high));
    }
  }

  Box box_;
  float scale_, margin_, n_refs_, step_;
  bool twice_;
  std::array<Axis, 3> axes_;
  std::array<Pair, 3> pairs_;
  std::vector<float> edges_, n_left_, n_right_;
};

}  // namespace fastlines
