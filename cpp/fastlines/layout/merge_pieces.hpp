// What a leaf of a layout lists: the references below a node of the tree, adjacent pieces of one segment joined.
#pragma once

#include <algorithm>
#include <bit>
#include <span>

#include "../references/reference.hpp"
#include "../simd/float_x16.hpp"

namespace fastlines {

/// More references are not looked at for a leaf.
inline constexpr std::size_t kMaxMergedRefs = 8 * kSimdWidth;

/// Write the pieces, of which there are no more than references; returns how many.
inline std::size_t merge_pieces(std::span<const Reference> below, Reference* to) {
  std::copy(below.begin(), below.end(), to);
  std::sort(to, to + below.size(),
            [](const Reference& a, const Reference& b) { return a.prim != b.prim ? a.prim < b.prim : a.s0 < b.s0; });
  std::size_t n = 0;
  for (std::size_t i = 0; i < below.size(); ++i)
    if (n > 0 && to[n - 1].prim == to[i].prim && to[n - 1].s1 == to[i].s0)
      to[n - 1].s1 = to[i].s1;
    else
      to[n++] = to[i];
  return n;
}

/// Whether these references are few enough for a leaf once adjacent pieces are joined. Most nodes have too many
/// segments for that, which is soon seen: so many marks can not be of fewer.
inline bool fits_leaf(std::span<const Reference> below) {
  constexpr std::size_t at_once = 2 * kSimdWidth;
  if (below.size() <= kSimdWidth) return true;
  if (below.size() > kMaxMergedRefs) return false;
  std::uint64_t marks[4] = {};
  for (std::size_t i = 0; i < below.size(); i += at_once) {
    for (const Reference& ref : below.subspan(i, std::min(at_once, below.size() - i))) {
      const std::uint32_t mark = ref.prim * 0x9e37'79b9u >> 24;
      marks[mark / 64] |= std::uint64_t(1) << (mark % 64);
    }
    int n = 0;
    for (const std::uint64_t some : marks) n += std::popcount(some);
    if (n > kSimdWidth) return false;
  }
  Reference pieces[kMaxMergedRefs];
  return merge_pieces(below, pieces) <= kSimdWidth;
}

}  // namespace fastlines
