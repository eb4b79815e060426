// Lists of (thing, ray) that phases hand to each other, packed without branches.
#pragma once

#include <algorithm>
#include <bit>
#include <vector>

#include "../../simd/float_x16.hpp"

namespace fastlines {

/// Write the numbers of those of n masks that have any bit, one after the other; returns how many. Reading and writing
/// may go sixteen past the end.
inline std::size_t nonzero_indices(const std::uint32_t* masks, std::size_t n, std::uint32_t* to) {
  std::size_t count_set = 0;
  for (std::size_t i = 0; i < n; i += kSimdWidth) {
    const std::uint32_t bits = nonzero_mask(masks + i) & lane_mask(n - i);
    compress_indices(bits, std::uint32_t(i), to + count_set);
    count_set += std::size_t(std::popcount(bits));
  }
  return count_set;
}

/// WorkList of a thing and the ray that it is for; writing may go sixteen past the end.
struct WorkList {
  std::vector<std::uint32_t> what, ray;
  std::size_t n = 0;

  bool empty() const { return n == 0; }
  std::size_t size() const { return n; }
  void clear() { n = 0; }
  void reserve(std::size_t more) {
    if (what.size() >= n + more) return;
    what.resize(2 * (n + more));
    ray.resize(2 * (n + more));
  }
  void push(std::uint32_t w, std::uint32_t r) {
    reserve(1);
    what[n] = w;
    ray[n++] = r;
  }
  /// Where a loop appends. One is kept in registers: a count in memory would be written and waited for in each turn.
  struct Appender {
    std::uint32_t *what, *ray;

    /// The things `base` + the numbers of these bits; room for sixteen is needed.
    void compress(std::uint32_t bits, std::uint32_t base, std::uint32_t r) {
      compress_indices(bits, base, what);
      std::fill_n(ray, kSimdWidth, r);
      const int n_packed = std::popcount(bits);
      what += n_packed;
      ray += n_packed;
    }
  };
  /// Begin to append at most so many.
  Appender appender(std::size_t at_most) {
    reserve(at_most + kSimdWidth);
    return {what.data() + n, ray.data() + n};
  }
  void end(const Appender& appender) { n = std::size_t(appender.what - what.data()); }
  /// Repeat the last pair, of one at least, sixteen times past the end, so that what is there can be read.
  void pad() {
    std::fill_n(what.data() + n, kSimdWidth, what[n - 1]);
    std::fill_n(ray.data() + n, kSimdWidth, ray[n - 1]);
  }
};

}  // namespace fastlines
