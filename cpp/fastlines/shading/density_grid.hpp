// How many lines light crosses, on average, from the density of lines in voxels.
//
// Let lines of radius R have the length l in a voxel of volume V, and the angle θ to a ray. There, the ray crosses
// 2·R·l·|sin θ| / V of them per unit length. Of all lines in a voxel, with unit directions t, the tensor
// T = Σ 2·R·l·t·tᵀ / V is kept. Then the number for a direction w is about
//
//     √(tr T · (tr T − wᵀ T w)).
//
// This is exact if all lines of the voxel are parallel, and 4 % too much if they run in all directions.
#pragma once

#include "../simd/lanes.hpp"
#include "line_density.hpp"

namespace fastlines {

/// Voxels of lines, and blocks of them for what is farther away.
class DensityGrid {
 public:
  /// The sides of a block, in voxels.
  static constexpr int kBlock = 4;
  /// Lines up to this distance are looked up in voxels, others in blocks; in sides of voxels.
  static constexpr float kNear = 8.0f;
  /// The least estimate. Where there are no other lines, some estimates are negative: only so is their mean 0.
  static constexpr float kLeast = -1.0f;

  DensityGrid(const VoxelBox& box, std::span<const LineTensor> voxels, std::span<const LineTensor> blocks)
      : box_(box), blocks_box_(blocks_of(box)), voxels_(voxels), blocks_(blocks) {}

  /// The blocks of a box of voxels. Those at its end may reach beyond it.
  static VoxelBox blocks_of(const VoxelBox& box) {
    VoxelBox blocks = box;
    for (int k = 0; k < 3; ++k) {
      blocks.n[k] = (box.n[k] + kBlock - 1) / kBlock;
      blocks.voxel[k] *= float(kBlock);
      blocks.per_voxel[k] /= float(kBlock);
    }
    return blocks;
  }

  /// The means of the tensors in each block.
  static void average(const VoxelBox& box, std::span<const LineTensor> voxels, std::span<LineTensor> blocks) {
    const VoxelBox of_blocks = blocks_of(box);
    std::fill(blocks.begin(), blocks.end(), LineTensor{});
    std::size_t voxel = 0;
    for (int z = 0; z < box.n[2]; ++z)
      for (int y = 0; y < box.n[1]; ++y)
        for (int x = 0; x < box.n[0]; ++x)
          blocks[of_blocks.number({x / kBlock, y / kBlock, z / kBlock})] +=
              voxels[voxel++] * (1.0f / float(kBlock * kBlock * kBlock));
  }

  /// The mean number of lines that light crosses on its way to a point of a line, and of these those that are far.
  struct OpticalDepth {
    FloatLanes all, far;
  };

  /// The optical depth up to the distance `end`, and that of lines beyond `far`. `towards` and `tangents` are unit
  /// vectors, and the lines have the radius. Uniform numbers jitter the points by the width of a voxel, so that the
  /// borders of voxels do not show.
  OpticalDepth optical_depth(const Vec3Lanes& points, const Vec3Lanes& tangents, const Vec3Lanes& towards, float radius,
                             float far, float end, const Vec3Lanes& jitter) const {
    const float unit = box_.longest_side(), start = 2.0f * radius;  // beyond the line itself
    const float switched = std::max(start, std::min(far, kNear * unit)), behind = std::max(switched, far);
    const Vec3Lanes from{points.x + (jitter.x - 0.5f) * box_.voxel[0], points.y + (jitter.y - 0.5f) * box_.voxel[1],
                         points.z + (jitter.z - 0.5f) * box_.voxel[2]};
    const FloatLanes near = march(box_, voxels_, from, towards, start, switched, unit) +
                            march(blocks_box_, blocks_, from, towards, switched, behind, unit * float(kBlock));
    const FloatLanes beyond = march(blocks_box_, blocks_, from, towards, behind, end, unit * float(kBlock));
    const FloatLanes others = (near + beyond) * (1.0f / unit) - own_share(tangents, towards, radius, start);
    return {max(others, FloatLanes(kLeast)), beyond * (1.0f / unit)};
  }

 private:
  /// Sum the lines that rays cross from t to t_end, in steps of some length.
  static FloatLanes march(const VoxelBox& box, std::span<const LineTensor> tensors, const Vec3Lanes& origins,
                          const Vec3Lanes& towards, float from, float to, float step) {
    // Clip the rays to the box.
    FloatLanes t = from, t_end = to;
    const FloatLanes origin[] = {origins.x, origins.y, origins.z}, direction[] = {towards.x, towards.y, towards.z};
    FloatLanes place[3], pace[3];
    for (int k = 0; k < 3; ++k) {
      const float n = float(box.n[k]), tiny = 1e-20f;
      place[k] = (origin[k] - box.low[k]) * box.per_voxel[k];
      pace[k] = direction[k] * box.per_voxel[k];
      const FloatLanes moving = select(abs(pace[k]) > tiny, pace[k], FloatLanes(tiny));
      const FloatLanes one = -place[k] / moving, other = (n - place[k]) / moving;
      t = max(t, min(one, other));
      t_end = min(t_end, max(one, other));
    }
    // Look up the middle of each step. A direction of length zero never leaves the box.
    FloatLanes sum = 0.0f;
    int steps_left = box.n[0] + box.n[1] + box.n[2] + 2;
    for (IntLanes goes_on = t < t_end; any(goes_on) && steps_left-- > 0; goes_on = t < t_end) {
      const FloatLanes length = select(goes_on, min(t_end - t, FloatLanes(step)), FloatLanes(0.0f));
      const FloatLanes middle = t + 0.5f * length;
      IntLanes cell[3];
      for (int k = 0; k < 3; ++k) {
        const FloatLanes at = place[k] + middle * pace[k], zero = 0.0f;
        cell[k] = to_int(select(at > zero, min(at, FloatLanes(float(box.n[k]) - 0.5f)), zero));  // NaN is 0
      }
      const IntLanes number = (cell[2] * box.n[1] + cell[1]) * box.n[0] + cell[0];
      sum += length * crossed(tensors, number, towards);
      t += step;
    }
    return sum;
  }

  /// How many lines rays with unit directions cross in a voxel per unit length.
  static FloatLanes crossed(std::span<const LineTensor> tensors, const IntLanes& number, const Vec3Lanes& w) {
    float found[6][kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const LineTensor& tensor = tensors[std::size_t(number[i])];
      for (int k = 0; k < 6; ++k) found[k][i] = tensor[k];
    }
    FloatLanes xx, yy, zz, xy, xz, yz;
    FloatLanes* const parts[] = {&xx, &yy, &zz, &xy, &xz, &yz};
    for (int k = 0; k < 6; ++k) *parts[k] = load_lanes(found[k], kLanes);
    const FloatLanes all = xx + yy + zz;
    const FloatLanes along =
        xx * w.x * w.x + yy * w.y * w.y + zz * w.z * w.z + 2.0f * (xy * w.x * w.y + xz * w.x * w.z + yz * w.y * w.z);
    return sqrt(max(all * (all - along), FloatLanes(0.0f)));
  }

  /// How often the march meets the line itself on average: half of a straight line, smeared over a voxel.
  FloatLanes own_share(const Vec3Lanes& tangents, const Vec3Lanes& towards, float radius, float start) const {
    const FloatLanes cosine = dot(tangents, towards), sine = sqrt(max(1.0f - cosine * cosine, FloatLanes(0.0f)));
    // Take the width of a voxel across the plane of both directions, and how much of it lies beyond the start.
    const float* const side = box_.voxel.data();
    const Vec3Lanes normal = Vec3Lanes{side[0], side[1], side[2]} * unit(cross(tangents, towards));
    const Vec3Lanes off = start * (towards - cosine * tangents);
    const FloatLanes zero = 0.0f, width = sqrt(dot(normal, normal));
    const auto left = [&](const FloatLanes& x, int k) { return max(1.0f - abs(x) * (1.0f / side[k]), zero); };
    const FloatLanes within = left(off.x, 0) * left(off.y, 1) * left(off.z, 2);
    return select((sine > 1e-3f) & (width > zero), radius / width * within * within, zero);
  }

  VoxelBox box_, blocks_box_;
  std::span<const LineTensor> voxels_, blocks_;
};

}  // namespace fastlines
