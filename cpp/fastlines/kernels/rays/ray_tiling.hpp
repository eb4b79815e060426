// In which order the rays of a batch are taken: in groups of up to 64 that are likely to run alike.
//
// Rays of a picture come row by row; eight pixels of eight rows lie limit_changed together than 64 of one row. The
// length of a row is seen in the rays themselves: the ray below the first one differs from it as little as its
// neighbour does.
#pragma once

#include "../../rays/ray_batch.hpp"
#include "ray_group.hpp"

namespace fastlines {

class RayTiling {
 public:
  explicit RayTiling(const RayBatch& rays) : n_rays_(rays.size()), row_(row_length(rays)) {
    if (row_ == 0) {
      n_groups_ = (n_rays_ + kGroupSize - 1) / kGroupSize;
      return;
    }
    for (std::size_t i = 0; i < kGroupSize; ++i) beside_[i] = std::uint32_t(down(i / 4) * row_ + across(i / 4) + i % 4);
    n_rows_ = (n_rays_ + row_ - 1) / row_;
    tiles_across_ = (row_ + kSide - 1) / kSide;
    n_groups_ = tiles_across_ * ((n_rows_ + kSide - 1) / kSide);
  }

  std::size_t n_groups() const { return n_groups_; }

  /// At least so many rays, from the first one on, are in the first groups.
  std::size_t n_rays_in(std::size_t n_groups) const {
    return row_ == 0 ? std::min(n_groups * kGroupSize, n_rays_)
                     : std::min(n_groups / tiles_across_ * kSide * row_, n_rays_);
  }

  /// The rays of a group, in place: at most 64; four tiles of four by four where the group is whole. Beside a last row
  /// that ends early there can be none.
  int group(std::size_t index, std::uint32_t* ids) const {
    int n = 0;
    if (row_ == 0) {
      const std::size_t begin = index * kGroupSize, end = std::min(begin + kGroupSize, n_rays_);
      for (std::size_t i = begin; i < end; ++i) ids[n++] = std::uint32_t(i);
      return n;
    }
    const std::size_t left = index % tiles_across_ * kSide, top = index / tiles_across_ * kSide;
    if (left + kSide <= row_ && (top + kSide) * row_ <= n_rays_) {
      for (; n < kGroupSize; ++n) ids[n] = std::uint32_t(top * row_ + left) + beside_[n];
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
  static constexpr std::size_t kSide = 8;

  /// Where in a group its yth four rays lie, those of a tile after each other.
  static std::size_t down(std::size_t y) { return (y & 3) + (y >> 3) * 4; }
  static std::size_t across(std::size_t y) { return y & 4; }

  /// How different two rays are. Euclidean, so that the ray right below is nearer than those beside it.
  static float step(const RayBatch& rays, std::size_t i, std::size_t j) {
    const Vec3 o = rays.origins[i] - rays.origins[j], d = rays.directions[i] - rays.directions[j];
    return std::sqrt(dot(o, o)) + std::sqrt(dot(d, d));
  }
  /// Whether they differ by more than `far`, found without roots as a rule.
  static bool is_beyond(const RayBatch& rays, std::size_t i, std::size_t j, float far) {
    const Vec3 o = rays.origins[i] - rays.origins[j], d = rays.directions[i] - rays.directions[j];
    return std::max(dot(o, o), dot(d, d)) > far * far || step(rays, i, j) > far;
  }

  /// The length of a row of pixels, or 0 if the rays look like no picture.
  static std::size_t row_length(const RayBatch& rays) {
    constexpr std::size_t kLook = 16, kLongest = 1 << 15;
    if (rays.size() < 4 * kLook) return 0;
    float steps[kLook];
    for (std::size_t i = 0; i < kLook; ++i) steps[i] = step(rays, i, i + 1);
    std::nth_element(steps, steps + kLook / 2, steps + kLook);
    const float pixel = steps[kLook / 2], near = 4.0f * pixel;
    if (!(step(rays, 0, kLook) > 8.0f * pixel)) return 0;  // the first rays are no row: they go nowhere
    const std::size_t longest = std::min(rays.size() / 2, kLongest);
    for (std::size_t row = kLook; row <= longest; ++row) {
      if (is_beyond(rays, 0, row, near)) continue;
      // Some pixels further the ray is right below, if this is a picture.
      std::size_t best = row;
      for (std::size_t i = row; i <= std::min(row + 8, longest); ++i)
        if (step(rays, 0, i) < step(rays, 0, best)) best = i;
      return best;
    }
    return 0;
  }

  std::size_t n_rays_, row_, n_rows_ = 0, tiles_across_ = 0, n_groups_ = 0;
  std::uint32_t beside_[kGroupSize];  // the rays of a whole group, counted from the first
};

}  // namespace fastlines
