// The planes of a regular grid over the node's box, the same number on each axis (thesis §4.3).
//
// One pass over the references counts all planes of an axis. The planes cut the box into bins. A reference enters at
// one bin and leaves at another, and grows the box of each bin from one to the other by the box of its part there. A
// sweep over the bins gives the counts and the tight boxes on both sides of every plane: O(n·(1 + planes crossed)) per
// axis.
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct PlaneGrid {
  static constexpr bool kTightOnly = false;
  int n_planes = 16;  ///< on each axis

  template <Primitives P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, CandidateVisitor visitor) const {
    const bool tight = rule == BoxRule::tight;
    thread_local Bins bins;
    for (int axis = 0; axis < 3; ++axis) {
      place(box, axis, bins.planes);
      if (bins.planes.empty()) continue;
      bins.clear(tight);
      fill(prims, refs, box, axis, tight, bins);

      // Sweep over the planes.
      const std::vector<float>& planes = bins.planes;
      Candidate split{Candidate::Kind::plane, axis, 0.0f, 0, refs.size(), box, box};
      if (tight) split.left = Box::empty();
      for (std::size_t i = 0; i < planes.size(); ++i) {
        split.plane = planes[i];
        split.n_left += bins.n_enter[i];
        split.n_right -= bins.n_leave[i];
        if (tight) {
          split.left.grow(bins.boxes[i]);
          split.right = bins.from[i + 1];
        } else {
          split.left.hi[axis] = split.right.lo[axis] = planes[i];
        }
        if (divides(split, rule)) visitor(split);
      }
    }
  }

 private:
  /// The bins between the planes: how many references begin and end in each, and the box of the parts in it.
  struct Bins {
    std::vector<float> planes;
    std::vector<std::uint32_t> n_enter, n_leave;
    std::vector<Box> boxes, from;  // from[i] bounds bin i and all after it

    void clear(bool tight) {
      n_enter.assign(planes.size() + 1, 0);
      n_leave.assign(planes.size() + 1, 0);
      if (tight) boxes.assign(planes.size() + 1, Box::empty());
    }
  };

  /// Place the planes strictly inside the box, in ascending order; none where the box is too thin for floats.
  void place(const Box& box, int axis, std::vector<float>& planes) const {
    planes.clear();
    const double step = box.side(axis) / (n_planes + 1);
    float previous = box.lo[axis];
    for (int i = 1; i <= n_planes; ++i) {
      const float plane = float(box.lo[axis] + i * step);
      if (plane <= previous || plane >= box.hi[axis]) continue;
      planes.push_back(plane);
      previous = plane;
    }
  }

  /// Add all references to the bins.
  template <Primitives P>
  static void fill(const P& prims, Refs refs, const Box& box, int axis, bool tight, Bins& bins) {
    const std::size_t n_planes = bins.planes.size();
    const float* planes = bins.planes.data();
    const double bins_per_length = double(n_planes + 1) / box.side(axis), origin = box.lo[axis];
    const auto guess = [&](float x) {
      return std::size_t(std::clamp((double(x) - origin) * bins_per_length, 0.0, double(n_planes)));
    };
    for (const BuildRef& ref : refs) {
      // Find the bins in which the reference begins (`first`) and ends (`last`).
      const float lo = ref.box.lo[axis], hi = ref.box.hi[axis];
      std::size_t last = guess(hi);
      while (last > 0 && planes[last - 1] >= hi) --last;
      while (last < n_planes && planes[last] < hi) ++last;
      std::size_t first = std::min(guess(lo), last);
      while (first > 0 && planes[first - 1] > lo) --first;
      while (first < last && planes[first] <= lo) ++first;
      ++bins.n_enter[first];
      ++bins.n_leave[last];
      if (!tight) continue;
      if (first == last)
        bins.boxes[first].grow(ref.box);
      else
        grow_bins(prims, ref, axis, std::span(planes + first, last - first), &bins.boxes[first]);
    }
    if (!tight) return;
    bins.from = bins.boxes;
    for (std::size_t i = n_planes; i-- > 0;) bins.from[i].grow(bins.from[i + 1]);
  }
};

}  // namespace fastlines
