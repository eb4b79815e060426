// Lists of (thing, ray) that phases hand to each other, packed without branches.
#pragma once

#include <algorithm>
#include <bit>
#include <vector>

#include "../simd/simd.hpp"

namespace fastlines {

/// Pairs of a thing and the ray that it is for; writing may go sixteen past the end.
struct Pairs {
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
  /// The things `base` + the numbers of these bits; room for sixteen is needed.
  void pack(std::uint32_t bits, std::uint32_t base, std::uint32_t r) {
    pack_numbers(bits, base, what.data() + n);
    std::fill_n(ray.data() + n, kWidth, r);
    n += std::size_t(std::popcount(bits));
  }
  /// Repeat the last thing sixteen times past the end, so that what is there can be read.
  void pad() { std::fill_n(what.data() + n, kWidth, what[n - (n > 0)]); }
};

}  // namespace fastlines
