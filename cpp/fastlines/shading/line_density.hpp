// The density of lines in voxels, and the directions in which they run: for each voxel of volume V, the tensor
// T = Σ 2·R·l·t·tᵀ / V of its lines, of radius R, length l and unit direction t.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "../math/box.hpp"
#include "../parallel/parallel_for.hpp"

namespace fastlines {

/// A symmetric tensor: xx, yy, zz, xy, xz, yz.
struct LineTensor : std::array<float, 6> {
  LineTensor& operator+=(const LineTensor& other) {
    for (int k = 0; k < 6; ++k) (*this)[k] += other[k];
    return *this;
  }
  LineTensor operator*(float s) const {
    LineTensor scaled;
    for (int k = 0; k < 6; ++k) scaled[k] = (*this)[k] * s;
    return scaled;
  }
};

/// Three whole numbers, such as those of the voxels along each axis.
using Counts = std::array<int, 3>;

/// A box in equal voxels. Its sides are above zero.
struct VoxelBox {
  Vec3 low, voxel, per_voxel;  // the corner, the sides of a voxel, and one over these
  Counts n;

  VoxelBox(const Box& box, const Counts& counts) : low(box.lo), n(counts) {
    for (int k = 0; k < 3; ++k) {
      voxel[k] = float(box.side(k) / n[k]);
      per_voxel[k] = float(n[k] / box.side(k));
    }
  }

  std::size_t size() const { return std::size_t(n[0]) * std::size_t(n[1]) * std::size_t(n[2]); }
  float longest_side() const { return std::max({voxel[0], voxel[1], voxel[2]}); }
  int cell(float x, int axis) const { return std::clamp(int((x - low[axis]) * per_voxel[axis]), 0, n[axis] - 1); }
  std::size_t number(const Counts& at) const {
    return (std::size_t(at[2]) * std::size_t(n[1]) + std::size_t(at[1])) * std::size_t(n[0]) + std::size_t(at[0]);
  }
};

/// Lines with a radius at each end, which is added to `radius`.
struct ThickLines {
  std::span<const std::array<Vec3, 2>> axes;
  std::span<const std::array<float, 2>> radii;
  float radius;

  /// Calls visit(point, weighted direction) for pieces of a line that are no longer than half a voxel. The square of
  /// the weighted direction is 2·R·l·t·tᵀ.
  template <class Visit>
  void pieces(std::size_t line, const VoxelBox& box, Visit&& visit) const {
    const auto& [start, end] = axes[line];
    const auto& [first_radius, last_radius] = radii[line];
    double length2 = 0.0, voxels = 0.0;
    std::array<double, 3> edge;
    for (int k = 0; k < 3; ++k) {
      edge[k] = double(end[k]) - double(start[k]);
      length2 += edge[k] * edge[k];
      voxels = std::max(voxels, std::abs(edge[k]) * double(box.per_voxel[k]));
    }
    if (!(length2 > 0.0)) return;
    const int n_pieces = 1 + int(std::min(2.0 * voxels, 1e6));
    for (int i = 0; i < n_pieces; ++i) {
      const double s = (i + 0.5) / n_pieces;
      const double width = 2.0 * (double(radius) + (1.0 - s) * double(first_radius) + s * double(last_radius));
      visit(Vec3{float(start[0] + s * edge[0]), float(start[1] + s * edge[1]), float(start[2] + s * edge[2])}, edge,
            width / (n_pieces * std::sqrt(length2)));
    }
  }
};

/// Adds lines to the tensors of voxels, whose unit of length is the longest side of a voxel. Each thread fills slabs of
/// voxels in the order of the lines, so that sums do not depend on the number of threads.
inline void add_lines(const ThickLines& lines, const VoxelBox& box, std::span<LineTensor> tensors, unsigned n_threads,
                      Progress& progress) {
  const int axis = int(std::max_element(box.n.begin(), box.n.end()) - box.n.begin());
  const int n_slabs = std::min(box.n[axis], 16);
  const double unit = double(box.longest_side()) / (double(box.voxel[0]) * double(box.voxel[1]) * double(box.voxel[2]));
  parallel_for(
      std::size_t(n_slabs), n_threads, progress, [&] { return Checkpoint(progress); },
      [&](Checkpoint& checkpoint, std::size_t slab) {
        const int low = int(slab) * box.n[axis] / n_slabs, high = (int(slab) + 1) * box.n[axis] / n_slabs;
        for (std::size_t line = 0; line < lines.axes.size(); ++line) {
          checkpoint.pass();
          const auto& [start, end] = lines.axes[line];
          if (box.cell(std::max(start[axis], end[axis]), axis) < low ||
              box.cell(std::min(start[axis], end[axis]), axis) >= high)
            continue;
          lines.pieces(line, box, [&](const Vec3& point, const std::array<double, 3>& edge, double weight) {
            const Counts at{box.cell(point[0], 0), box.cell(point[1], 1), box.cell(point[2], 2)};
            if (at[axis] < low || at[axis] >= high) return;
            const double s = weight * unit, x = edge[0], y = edge[1], z = edge[2];
            tensors[box.number(at)] += LineTensor{{float(s * x * x), float(s * y * y), float(s * z * z),
                                                   float(s * x * y), float(s * x * z), float(s * y * z)}};
          });
        }
      });
}

}  // namespace fastlines
