// Merges adjacent pieces of one segment among the references below a node, for a leaf of the layout. Of primitives
// without pieces, several references become one.
#pragma once

#include <algorithm>
#include <bit>
#include <span>

#include "../references/reference.hpp"
#include "../simd/float_x16.hpp"

namespace fastlines {

/// A node with more references never becomes a leaf, even if few enough would remain after merging.
inline constexpr std::size_t kMaxMergedRefs = 8 * kSimdWidth;

/// Write the merged pieces, sorted by id and s0. Returns their number; `to` has room for all references.
inline std::size_t merge_pieces(std::span<const Reference> below, Reference* to) {
  std::copy(below.begin(), below.end(), to);
  std::sort(to, to + below.size(),
            [](const Reference& a, const Reference& b) { return a.prim != b.prim ? a.prim < b.prim : a.s0 < b.s0; });
  std::size_t n = 0;
  for (std::size_t i = 0; i < below.size(); ++i)
    if (n > 0 && to[n - 1].prim == to[i].prim && to[n - 1].s1 >= to[i].s0)
      to[n - 1].s1 = std::max(to[n - 1].s1, to[i].s1);
    else
      to[n++] = to[i];
  return n;
}

/// Whether these references fit into a leaf after merging. Most nodes have too many segments. Hashing ids to 256 bits
/// detects that early: the number of set bits is a lower bound on the number of segments.
inline bool fits_leaf(std::span<const Reference> below) {
  constexpr std::size_t batch = 2 * kSimdWidth;
  if (below.size() <= kSimdWidth) return true;
  if (below.size() > kMaxMergedRefs) return false;
  std::uint64_t bits[4] = {};
  for (std::size_t i = 0; i < below.size(); i += batch) {
    for (const Reference& ref : below.subspan(i, std::min(batch, below.size() - i))) {
      const std::uint32_t bit = ref.prim * 0x9e37'79b9u >> 24;
      bits[bit / 64] |= std::uint64_t(1) << (bit % 64);
    }
    int n = 0;
    for (const std::uint64_t word : bits) n += std::popcount(word);
    if (n > kSimdWidth) return false;
  }
  Reference pieces[kMaxMergedRefs];
  return merge_pieces(below, pieces) <= kSimdWidth;
}

}  // namespace fastlines
