// What a child of a node costs at least, before it is carried out: a bound for branch and bound (docs/theory.md).
//
// Let the box of a child be cut once more, anywhere, so that its n references fall to both sides: n1 + n2 ≥ n. The
// planes of the parent have counted what lies on one side of them only. Beyond a plane with R references only on its
// right, a cut leaves n1 ≥ n − R − m on the left, where m references were cut short by the split that made the child;
// likewise on the other side. The areas A1, A2 of both sides are at least those up to the planes next to the cut, and
// A1·n1 + A2·n2 is least where one of the two numbers is as small as it can be.
#pragma once

#include <array>

#include "../splits/candidate.hpp"

// Vectors go in and out of inline functions only. GCC comes to templates last, so there is no place to take this back.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace fastlines {

/// The planes of a node as its candidates have counted them.
class PlaneCounts {
 public:
  void begin(const Box& box, std::size_t n_refs, double margin) {
    box_ = box;
    n_refs_ = double(n_refs);
    margin_ = margin;
    for (auto& planes : planes_) planes.clear();
  }

  void add(const Candidate& split) {
    planes_[std::size_t(split.axis)].push_back(
        {split.plane, n_refs_ - double(split.n_right), n_refs_ - double(split.n_left)});
  }

  /// Once all planes are there.
  void finish() {
    for (int axis = 0; axis < 3; ++axis) {
      auto& planes = planes_[std::size_t(axis)];
      std::sort(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) { return a.at < b.at; });
      Plane before{box_.lo[axis], 0.0, n_refs_};
      planes.push_back({box_.hi[axis], n_refs_, 0.0});
      const std::size_t n_gaps = planes.size();
      auto& gaps = gaps_[std::size_t(axis)];
      gaps.resize((n_gaps + 3) / 4);
      for (std::size_t i = 0; i < gaps.size() * 4; ++i) {
        const Plane& plane = planes[std::min(i, n_gaps - 1)];  // the last fills the lanes that are left
        Gaps& four = gaps[i / 4];
        four.from[i % 4] = before.at;
        four.only_right[i % 4] = before.n_only_right;
        four.to[i % 4] = plane.at;
        four.only_left[i % 4] = plane.n_only_left;
        if (i + 1 < n_gaps) before = plane;
      }
    }
  }

  /// Σ n·SA/SA(box) over both sides is at least this, however a child with n references, m of them cut short, is cut.
  double least_cut(const Box& box, double n, double n_short) const {
    const double area = box.area(margin_), n_whole = n - n_short;
    const Four all = Four{} + n, none = {};
    Four least = Four{} + n * area;
    for (int axis = 0; axis < 3; ++axis) {
      const double y = box.side((axis + 1) % 3) + 2 * margin_, z = box.side((axis + 2) % 3) + 2 * margin_;
      const double face = 2 * (y * z + (y + z) * 2 * margin_), per_length = 2 * (y + z);
      const double lo = box.lo[axis], hi = box.hi[axis];
      for (const Gaps& gap : gaps_[std::size_t(axis)]) {
        const Four area_left = face + per_length * max(none, gap.from - lo),
                   area_right = face + per_length * max(none, hi - gap.to);
        const Four n_left = max(none, n_whole - gap.only_right), n_right = max(none, n_whole - gap.only_left);
        least = min(least, area_left * n_left + area_right * max(n_right, all - n_left));
        least = min(least, area_left * max(n_left, all - n_right) + area_right * n_right);
      }
    }
    return area > 0.0 ? std::min(std::min(least[0], least[1]), std::min(least[2], least[3])) / area : 0.0;
  }

 private:
  struct Plane {
    double at, n_only_left, n_only_right;
  };
  using Four = double __attribute__((vector_size(32)));
  [[gnu::always_inline]] static Four min(Four x, Four y) { return x < y ? x : y; }
  [[gnu::always_inline]] static Four max(Four x, Four y) { return x > y ? x : y; }

  /// Four gaps between planes: what lies only right of the lower one, only left of the upper one.
  struct Gaps {
    Four from, to, only_right, only_left;
  };

  Box box_;
  double n_refs_, margin_;
  std::array<std::vector<Plane>, 3> planes_;
  std::array<std::vector<Gaps>, 3> gaps_;
};

}  // namespace fastlines
