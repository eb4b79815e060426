// The traversal stacks of a wavefront, one per lane.
//
// An entry is a node with inner children that wait: which children, and where the ray enters each. Entries need neither
// compression nor sorting.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lane_set.hpp"

namespace fastlines {

/// Entries are indexed by level · kStride + lane. At level 0 no child ever waits; the root's entry is at level 1.
/// Without `has_distances` the entries do not store where children are entered.
template <bool has_distances>
class WavefrontStacks {
 public:
  /// Where a ray enters the children of a node, per child: t in the frame.
  struct alignas(64) EntryDistances {
    float of[kSimdWidth];
  };
  /// The first inner child of a node, and a mask of the children that wait.
  struct Entry {
    std::uint32_t first_child, waiting;
  };
  /// Pointers to all entries. A loop keeps a copy, so that no store can alias it.
  struct View {
    EntryDistances* distances;
    Entry* entries;
  };

  /// From one level to the next. Odd, so that the entries of a lane do not share cache sets.
  static constexpr std::int32_t kStride = kGroupSize + 1;
  /// kStride or 0, without a branch: a compiler may compile a conditional expression to one.
  static std::int32_t stride_if(bool is) { return -std::int32_t(is) & kStride; }

  WavefrontStacks() { resize(kInitialLevels); }

  View view() { return {distances_.data(), entries_.data()}; }

  /// Make room for the entries of one step, at most one per lane. `top` is the index of the uppermost entry of each
  /// active lane.
  void prepare_step(std::uint64_t active, const std::int32_t* top) {
    if (++max_level_ >= n_levels_) grow(active, top);
  }

 private:
  static constexpr std::int32_t kInitialLevels = 8, kRootLevel = 1;

  void grow(std::uint64_t active, const std::int32_t* top) {
    max_level_ = kRootLevel;
    for_each_lane(active, [&](std::uint32_t ray) { max_level_ = std::max(max_level_, top[ray] / kStride + 1); });
    if (2 * max_level_ >= n_levels_) resize(2 * n_levels_);  // so that many steps pass before the next scan
  }

  void resize(std::int32_t n_levels) {
    if constexpr (has_distances) distances_.resize(std::size_t(kStride * n_levels));
    entries_.resize(std::size_t(kStride * n_levels));
    n_levels_ = n_levels;
  }

  std::vector<EntryDistances> distances_;
  std::vector<Entry> entries_;
  std::int32_t n_levels_ = 0, max_level_ = kRootLevel;  // allocated; an upper bound of those in use
};

}  // namespace fastlines
