// Random trees over given primitives that keep all axioms, or nearly: cuts are off by an ulp now and then.
#pragma once

#include <cmath>

#include "fastlines/core.hpp"
#include "tests/random.hpp"

namespace fastlines::fuzz {

/// Grows one tree. P is Segments, whose pieces have references of their own, or Shapes.
template <Primitives P>
class RandomTree {
 public:
  RandomTree(const P& prims, bool is_cut, test::Random& random) : prims_(prims), is_cut_(is_cut), random_(random) {}

  Tree operator()() {
    std::vector<Reference> all;
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim) all.push_back({prim});
    grow(all, prims_.size() == 0 ? Box{{0, 0, 0}, {0, 0, 0}} : bounds_of_all(prims_), 0);
    return std::move(tree_);
  }

 private:
  using References = std::vector<Reference>;
  static constexpr std::size_t kMostLevels = 10, kMostRefs = 256;

  void grow(const References& refs, const Box& box, std::size_t level) {
    const std::size_t index = tree_.nodes.size();
    const auto first = std::uint32_t(tree_.refs.size());
    tree_.nodes.push_back({box, 0, first, std::uint32_t(refs.size())});
    References left, right;
    Box left_box = box, right_box = box;
    const bool is_leaf = level == kMostLevels || refs.size() <= random_.below(4) || refs.size() > kMostRefs;
    if (is_leaf || !split(refs, left, right, left_box, right_box)) {
      for (const Reference& ref : refs) tree_.refs.push_back(ref);
      return;
    }
    grow(left, left_box, level + 1);
    tree_.nodes[index].right = std::uint32_t(tree_.nodes.size());
    grow(right, right_box, level + 1);
    tree_.nodes[index].n_refs = std::uint32_t(tree_.refs.size()) - first;
  }

  /// Distribute references to two children. Returns whether it can.
  bool split(const References& refs, References& left, References& right, Box& left_box, Box& right_box) {
    const Box box = left_box;
    const bool by_plane = is_cut_ || random_.below(2);
    const int axis = int(random_.below(3));
    if (by_plane && !(box.lo[axis] < box.hi[axis])) return false;
    if (by_plane) {
      const float plane = choose_plane(refs, box, axis);
      for (const Reference& ref : refs) cut(ref, axis, plane, left, right);
      left_box.hi[axis] = right_box.lo[axis] = plane;
    } else {
      for (const Reference& ref : refs) (random_.below(2) ? left : right).push_back(ref);
    }
    if (is_cut_) return true;
    left_box = bounds_of(left, left_box);
    right_box = bounds_of(right, right_box);
    return true;
  }

  float choose_plane(const References& refs, const Box& box, int axis) {
    float plane = box.lo[axis] + random_.uniform() * (box.hi[axis] - box.lo[axis]);
    if (!refs.empty() && random_.below(2)) {
      const Box part = piece_box(refs[random_.below(refs.size())], box);
      plane = random_.below(2) ? part.lo[axis] : part.hi[axis];
    }
    return std::clamp(plane, box.lo[axis], box.hi[axis]);
  }

  void cut(const Reference& ref, int axis, float plane, References& left, References& right) {
    const Box part = piece_box(ref, {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}});
    if (part.hi[axis] <= plane) return left.push_back(ref);
    if (part.lo[axis] >= plane) return right.push_back(ref);
    if constexpr (Curves<P>) {
      const Segment& line = prims_.curve(ref.prim);
      float s = float((double(plane) - line.p[axis]) / (double(line.q[axis]) - line.p[axis]));
      if (random_.below(8) == 0) s = std::nextafter(s, random_.below(2) ? 2.0f : -1.0f);
      s = std::clamp(s, ref.s0, std::min(ref.s1, 1.0f));
      const bool is_rising = line.q[axis] > line.p[axis];
      (is_rising ? left : right).push_back({ref.prim, ref.s0, s});
      (is_rising ? right : left).push_back({ref.prim, s, ref.s1});
    } else {
      left.push_back(ref);
      right.push_back(ref);
    }
  }

  Box piece_box(const Reference& ref, const Box& box) const {
    if constexpr (Curves<P>) {
      Box ends = Box::empty();
      ends.grow(prims_.curve(ref.prim).point(ref.s0));
      ends.grow(prims_.curve(ref.prim).point(std::min(ref.s1, 1.0f)));
      return ends;
    } else {
      return prims_.clipped_bounds(ref.prim, box);
    }
  }

  /// The box of some pieces, within that of their parent.
  Box bounds_of(const References& refs, const Box& within) const {
    Box box = Box::empty();
    for (const Reference& ref : refs) box.grow(piece_box(ref, within));
    if (box.is_empty()) return {within.lo, within.lo};
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::clamp(box.lo[k], within.lo[k], within.hi[k]);
      box.hi[k] = std::clamp(box.hi[k], within.lo[k], within.hi[k]);
    }
    return box;
  }

  const P& prims_;
  const bool is_cut_;
  test::Random& random_;
  Tree tree_;
};

}  // namespace fastlines::fuzz
