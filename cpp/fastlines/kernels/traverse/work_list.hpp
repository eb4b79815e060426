// A work list of (item, ray) pairs that one phase of a traversal hands to the next, filled without branches.
#pragma once

#include <algorithm>
#include <bit>
#include <vector>

#include "../../simd/float_x16.hpp"

namespace fastlines {

/// Write the indices of the nonzero ones of n masks to `to`, in order, and return their number. Up to 16 masks past the
/// end are read, and up to 16 indices past the end are written.
inline std::size_t nonzero_indices(const std::uint32_t* masks, std::size_t n, std::uint32_t* to) {
  std::size_t n_nonzero = 0;
  for (std::size_t i = 0; i < n; i += kSimdWidth) {
    const std::uint32_t bits = nonzero_mask(masks + i) & lane_mask(n - i);
    compress_indices(bits, std::uint32_t(i), to + n_nonzero);
    n_nonzero += std::size_t(std::popcount(bits));
  }
  return n_nonzero;
}

/// Pairs of an item (the index of a node, a leaf or a reference) and the lane of its ray, as two columns.
struct WorkList {
  std::vector<std::uint32_t> item, ray;
  std::size_t n = 0;

  bool empty() const { return n == 0; }
  std::size_t size() const { return n; }
  void clear() { n = 0; }
  void reserve(std::size_t more) {
    if (item.size() >= n + more) return;
    item.resize(2 * (n + more));
    ray.resize(2 * (n + more));
  }
  void push(std::uint32_t new_item, std::uint32_t new_ray) {
    reserve(1);
    item[n] = new_item;
    ray[n++] = new_ray;
  }
  /// The end of a list while a loop appends to the list. An appender stays in registers; a count in memory would be
  /// stored and reloaded in each iteration.
  struct Appender {
    std::uint32_t *item, *ray;

    /// Append the items `base` + i for each bit i of `bits`, all for one ray. Writes 16 pairs.
    void compress(std::uint32_t bits, std::uint32_t base, std::uint32_t r) {
      compress_indices(bits, base, item);
      std::fill_n(ray, kSimdWidth, r);
      const int n_added = std::popcount(bits);
      item += n_added;
      ray += n_added;
    }
  };
  /// An appender with room for `max_pairs` pairs. Pass it to `commit` when the loop is done.
  Appender appender(std::size_t max_pairs) {
    reserve(max_pairs + kSimdWidth);
    return {item.data() + n, ray.data() + n};
  }
  void commit(const Appender& appender) { n = std::size_t(appender.item - item.data()); }
  /// Repeat the last pair 16 times past the end, so that whole packets can be read. The list must not be empty, and
  /// must have room.
  void pad() {
    std::fill_n(item.data() + n, kSimdWidth, item[n - 1]);
    std::fill_n(ray.data() + n, kSimdWidth, ray[n - 1]);
  }
};

}  // namespace fastlines
