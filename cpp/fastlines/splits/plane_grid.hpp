// The planes of a regular grid over the node's box, the same number on each axis (§4.3).
//
// All planes of an axis are counted in one pass: the planes cut the box into bins; each reference enters at one
// bin and leaves at another, and gives each bin between the box of its part there. A sweep over the bins then has
// the counts and the tight boxes on both sides of every plane. O(n·(1 + planes crossed)) an axis.
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct PlaneGrid {
  int n_planes = 16;

  template <Primitives P, class Visitor>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, Visitor&& visitor) const {
    struct Bin {
      Box box = Box::empty();
      std::size_t n_enter = 0, n_leave = 0;
    };
    std::vector<float> planes;
    std::vector<Bin> bins;
    std::vector<Box> from;
    for (int axis = 0; axis < 3; ++axis) {
      place(box, axis, planes);
      if (planes.empty()) continue;
      const std::size_t n_bins = planes.size() + 1;
      const double per_plane = double(n_bins) / box.side(axis);

      // Fill the bins.
      bins.assign(n_bins, Bin{});
      for (const BuildRef& ref : refs) {
        const auto guess = [&](float x) {
          const double bin = (double(x) - double(box.lo[axis])) * per_plane;
          return std::size_t(std::clamp(bin, 0.0, double(n_bins - 1)));
        };
        // The first plane that has all of the reference on its left, the last that has all of it on its right.
        const float lo = ref.box.lo[axis], hi = ref.box.hi[axis];
        std::size_t last = guess(hi);
        while (last > 0 && planes[last - 1] >= hi) --last;
        while (last < planes.size() && planes[last] < hi) ++last;
        std::size_t first = std::min(guess(lo), last);
        while (first > 0 && planes[first - 1] > lo) --first;
        while (first < last && planes[first] <= lo) ++first;
        ++bins[first].n_enter;
        ++bins[last].n_leave;
        if (rule == BoxRule::cut) continue;
        BuildRef rest = ref;
        for (std::size_t i = first; i < last; ++i) {
          const auto [left, right] = cut(prims, rest, axis, planes[i]);
          bins[i].box.grow(left.box);
          rest = right;
        }
        bins[last].box.grow(rest.box);
      }

      // Sweep them.
      from.assign(n_bins, Box::empty());
      Box right = Box::empty();
      for (std::size_t i = n_bins; i-- > 0;) {
        right.grow(bins[i].box);
        from[i] = right;
      }
      Box left = Box::empty();
      std::size_t n_left = 0, n_right = refs.size();
      for (std::size_t i = 0; i < planes.size(); ++i) {
        left.grow(bins[i].box);
        n_left += bins[i].n_enter;
        n_right -= bins[i].n_leave;
        Candidate split{Candidate::Kind::plane, axis, planes[i], n_left, n_right, left, from[i + 1]};
        if (rule == BoxRule::cut) std::tie(split.left, split.right) = halves(box, axis, planes[i]);
        if (divides(split, rule)) visitor(split);
      }
    }
  }

 private:
  /// The planes that lie strictly inside the box, rising; none where the box is too thin for floats to divide.
  void place(const Box& box, int axis, std::vector<float>& planes) const {
    planes.clear();
    float previous = box.lo[axis];
    for (int i = 1; i <= n_planes; ++i) {
      const float plane = float(box.lo[axis] + box.side(axis) * i / (n_planes + 1));
      if (plane <= previous || plane >= box.hi[axis]) continue;
      planes.push_back(plane);
      previous = plane;
    }
  }
};

}  // namespace fastlines
