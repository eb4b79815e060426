// A uniform grid over beams: each cell lists the beams whose capsule may touch it. A ray walks through the cells by a
// three-dimensional DDA (Amanatides and Woo 1987), and a mailbox keeps it from testing a beam twice (Cleary and Wyvill
// 1988).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

/// A beam from p along its edge e, half a cache line.
struct Beam {
  float p[3], e[3];
  std::uint32_t unused[2];
};
static_assert(sizeof(Beam) == 32);

using Cell = std::array<int, 3>;

class Grid {
 public:
  /// A grid of cubic cells, `resolution` of them along the longest side of the beams' box.
  Grid(std::vector<Beam> beams, float radius, int resolution) : beams_(std::move(beams)), radius_(1.0001f * radius) {
    bound(resolution);
    // Count the references of each cell, then store them.
    std::vector<std::uint32_t> count(std::size_t(n_[0]) * n_[1] * n_[2] + 1, 0);
    for (const Beam& beam : beams_) rasterise(beam, [&](std::size_t cell) { ++count[cell + 1]; });
    first_.assign(count.begin(), count.end());
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    refs_.resize(first_.back());
    std::vector<std::uint64_t> at(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < beams_.size(); ++i)
      rasterise(beams_[i], [&](std::size_t cell) { refs_[at[cell]++] = i; });
  }

  const std::vector<Beam>& beams() const { return beams_; }
  std::size_t bytes() const { return 8 * first_.size() + 4 * refs_.size() + sizeof(Beam) * beams_.size(); }

  /// Calls visit(first, last) with the references of each cell that the part [t0, t1] of a ray passes.
  template <class Visit>
  void walk(const float (&o)[3], const float (&r)[3], float t0, float t1, Visit&& visit) const {
    // Clip the ray to the box.
    for (int k = 0; k < 3; ++k) {
      const float a = (low_[k] - o[k]) / r[k], b = (low_[k] + n_[k] * side_ - o[k]) / r[k];
      if (r[k] == 0.0f && (o[k] < low_[k] || o[k] > low_[k] + n_[k] * side_)) return;
      if (r[k] == 0.0f) continue;
      t0 = std::max(t0, std::min(a, b));
      t1 = std::min(t1, std::max(a, b));
    }
    if (t0 > t1) return;

    // Step from cell to cell.
    Cell cell, step;
    float next[3], delta[3];
    for (int k = 0; k < 3; ++k) {
      cell[k] = std::clamp(int((o[k] + t0 * r[k] - low_[k]) / side_), 0, n_[k] - 1);
      step[k] = r[k] > 0 ? 1 : -1;
      delta[k] = side_ / std::abs(r[k]);
      next[k] =
          r[k] == 0 ? std::numeric_limits<float>::infinity() : (low_[k] + (cell[k] + (r[k] > 0)) * side_ - o[k]) / r[k];
    }
    for (;;) {
      const std::size_t i = index(cell);
      visit(refs_.data() + first_[i], refs_.data() + first_[i + 1]);
      const int k = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      if (next[k] > t1) return;
      cell[k] += step[k];
      if (cell[k] < 0 || cell[k] >= n_[k]) return;
      next[k] += delta[k];
    }
  }

 private:
  std::size_t index(const Cell& cell) const { return (std::size_t(cell[2]) * n_[1] + cell[1]) * n_[0] + cell[0]; }

  /// Finds the box of all capsules, slightly enlarged, and divides it into cells.
  void bound(int resolution) {
    float high[3], longest = 0.0f;
    for (int k = 0; k < 3; ++k) {
      low_[k] = std::numeric_limits<float>::infinity(), high[k] = -low_[k];
      for (const Beam& beam : beams_) {
        low_[k] = std::min({low_[k], beam.p[k], beam.p[k] + beam.e[k]});
        high[k] = std::max({high[k], beam.p[k], beam.p[k] + beam.e[k]});
      }
      longest = std::max(longest, high[k] - low_[k]);
    }
    slack_ = radius_ + 1e-5f * longest;
    side_ = (longest + 2 * slack_) / resolution;
    for (int k = 0; k < 3; ++k) {
      low_[k] -= slack_;
      n_[k] = std::max(1, int(std::ceil((high[k] + slack_ - low_[k]) / side_)));
    }
  }

  /// Calls add(cell) for all cells that the capsule may touch: slab after slab along the axis of its largest extent.
  template <class Add>
  void rasterise(const Beam& beam, Add&& add) const {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(beam.e[k]) > std::abs(beam.e[axis])) axis = k;
    const float ee = beam.e[0] * beam.e[0] + beam.e[1] * beam.e[1] + beam.e[2] * beam.e[2];
    const float reach = slack_ + 0.8661f * side_, reach2 = reach * reach;  // half a cell's diagonal
    const auto cell_of = [&](float x, int k) { return std::clamp(int((x - low_[k]) / side_), 0, n_[k] - 1); };
    const float a = beam.p[axis], b = a + beam.e[axis];
    const int last = cell_of(std::max(a, b) + slack_, axis);
    Cell cell;
    for (cell[axis] = cell_of(std::min(a, b) - slack_, axis); cell[axis] <= last; ++cell[axis]) {
      // Bound the part of the capsule within the slab.
      const float from = low_[axis] + cell[axis] * side_ - slack_, to = from + side_ + 2 * slack_;
      float s0 = 0.0f, s1 = 1.0f;
      if (beam.e[axis] != 0.0f) {
        const float sa = (from - a) / beam.e[axis], sb = (to - a) / beam.e[axis];
        s0 = std::clamp(std::min(sa, sb), 0.0f, 1.0f), s1 = std::clamp(std::max(sa, sb), 0.0f, 1.0f);
      }
      const int j = (axis + 1) % 3, k = (axis + 2) % 3;
      const auto range = [&](int m) {
        const float x0 = beam.p[m] + s0 * beam.e[m], x1 = beam.p[m] + s1 * beam.e[m];
        return std::array{cell_of(std::min(x0, x1) - slack_, m), cell_of(std::max(x0, x1) + slack_, m)};
      };
      const auto [j0, j1] = range(j);
      const auto [k0, k1] = range(k);
      for (cell[j] = j0; cell[j] <= j1; ++cell[j])
        for (cell[k] = k0; cell[k] <= k1; ++cell[k]) {
          // Leave cells out whose middle is too far from the beam's line.
          float d[3], de = 0.0f, dd = 0.0f;
          for (int m = 0; m < 3; ++m) {
            d[m] = low_[m] + (cell[m] + 0.5f) * side_ - beam.p[m];
            de += d[m] * beam.e[m];
            dd += d[m] * d[m];
          }
          if (ee == 0.0f || dd - de * de / ee <= reach2) add(index(cell));
        }
    }
  }

  std::vector<Beam> beams_;
  float radius_, slack_ = 0.0f, side_ = 0.0f, low_[3];
  Cell n_{};
  std::vector<std::uint64_t> first_;  // of each cell, and the end
  std::vector<std::uint32_t> refs_;
};

}  // namespace
