// Divides the rays of a batch into groups of up to 64 that are likely to be coherent.
//
// Rays of a picture come row by row; a tile of 8 × 8 pixels is more coherent than 64 pixels of one row. The length of a
// row is detected from the rays: the ray below the first one differs from it about as little as the next one in the
// row.
#pragma once

#include "../../rays/ray_batch.hpp"
#include "ray_group.hpp"

namespace fastlines {

/// Tiles of 8 × 8 rays if the batch is a picture, otherwise runs of 64.
class RayTiling {
 public:
  explicit RayTiling(const RayBatch& rays) : n_rays_(rays.size()), row_(row_length(rays)) {
    if (row_ == 0) {
      n_groups_ = (n_rays_ + kGroupSize - 1) / kGroupSize;
      return;
    }
    for (std::size_t i = 0; i < kGroupSize; ++i)
      tile_ids_[i] = std::uint32_t(down(i / 4) * row_ + across(i / 4) + i % 4);
    n_rows_ = (n_rays_ + row_ - 1) / row_;
    tiles_across_ = (row_ + kSide - 1) / kSide;
    n_groups_ = tiles_across_ * ((n_rows_ + kSide - 1) / kSide);
  }

  std::size_t n_groups() const { return n_groups_; }

  /// A lower bound: the first `n_groups` groups contain at least this many of the first rays.
  std::size_t n_rays_in(std::size_t n_groups) const {
    return row_ == 0 ? std::min(n_groups * kGroupSize, n_rays_)
                     : std::min(n_groups / tiles_across_ * kSide * row_, n_rays_);
  }

  /// Write the ids of a group's rays, and return their number, at most 64. A whole group is four tiles of 4 × 4. A
  /// group can be empty if the last row ends early.
  int group(std::size_t index, std::uint32_t* ids) const {
    int n = 0;
    if (row_ == 0) {
      const std::size_t begin = index * kGroupSize, end = std::min(begin + kGroupSize, n_rays_);
      for (std::size_t i = begin; i < end; ++i) ids[n++] = std::uint32_t(i);
      return n;
    }
    const std::size_t left = index % tiles_across_ * kSide, top = index / tiles_across_ * kSide;
    if (left + kSide <= row_ && (top + kSide) * row_ <= n_rays_) {
      for (; n < kGroupSize; ++n) ids[n] = std::uint32_t(top * row_ + left) + tile_ids_[n];
      return n;
    }
    for (std::size_t y = 0; y < kGroupSize / 4; ++y) {
      const std::size_t column = left + across(y), at = (top + down(y)) * row_ + column;
      if (column >= row_ || at >= n_rays_) continue;
      const std::size_t end = at + std::min({std::size_t(4), row_ - column, n_rays_ - at});
      for (std::size_t i = at; i < end; ++i) ids[n++] = std::uint32_t(i);
    }
    return n;
  }

 private:
  static constexpr std::size_t kSide = 8;  // of a tile, in rays

  /// The row and the column, in a group, of its y-th run of four rays. The runs of a tile are consecutive.
  static std::size_t down(std::size_t y) { return (y & 3) + (y >> 3) * 4; }
  static std::size_t across(std::size_t y) { return y & 4; }

  /// The difference of two rays, as a Euclidean distance, so that the ray directly below is closer than the neighbours
  /// of that ray.
  static float difference(const RayBatch& rays, std::size_t i, std::size_t j) {
    const Vec3 o = rays.origins[i] - rays.origins[j], d = rays.directions[i] - rays.directions[j];
    return std::sqrt(dot(o, o)) + std::sqrt(dot(d, d));
  }
  /// Whether two rays differ by more than `far`; usually needs no square root.
  static bool is_beyond(const RayBatch& rays, std::size_t i, std::size_t j, float far) {
    const Vec3 o = rays.origins[i] - rays.origins[j], d = rays.directions[i] - rays.directions[j];
    return std::max(dot(o, o), dot(d, d)) > far * far || difference(rays, i, j) > far;
  }

  /// The length of a row of pixels, or 0 if the rays do not look like a picture.
  static std::size_t row_length(const RayBatch& rays) {
    constexpr std::size_t kSampleRays = 16, kMaxRow = 1 << 15;  // rays
    if (rays.size() < 4 * kSampleRays) return 0;
    float steps[kSampleRays];
    for (std::size_t i = 0; i < kSampleRays; ++i) steps[i] = difference(rays, i, i + 1);
    std::nth_element(steps, steps + kSampleRays / 2, steps + kSampleRays);
    const float pixel = steps[kSampleRays / 2], near = 4.0f * pixel;
    if (!(difference(rays, 0, kSampleRays) > 8.0f * pixel)) return 0;  // the first rays do not advance along a row
    const std::size_t longest = std::min(rays.size() / 2, kMaxRow);
    for (std::size_t row = kSampleRays; row <= longest; ++row) {
      if (is_beyond(rays, 0, row, near)) continue;
      // In a picture, the ray directly below follows within a few pixels.
      std::size_t best = row;
      for (std::size_t i = row; i <= std::min(row + 8, longest); ++i)
        if (difference(rays, 0, i) < difference(rays, 0, best)) best = i;
      return best;
    }
    return 0;
  }

  std::size_t n_rays_, row_, n_rows_ = 0, tiles_across_ = 0, n_groups_ = 0;
  std::uint32_t tile_ids_[kGroupSize];  // ids of a whole group, relative to its first
};

}  // namespace fastlines
