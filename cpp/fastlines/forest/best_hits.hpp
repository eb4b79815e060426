// The best hits of each ray so far, while tile after tile answers.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../memory/large_vector.hpp"
#include "../rays/hit.hpp"

namespace fastlines {

/// The numbers of a tile's primitives in the forest; empty if they are the same.
struct GlobalIds {
  std::span<const std::int64_t> ids;

  std::int64_t operator()(std::int64_t prim) const { return ids.empty() || prim < 0 ? prim : ids[std::size_t(prim)]; }
};

/// Keeps hit j of a tile as the first hit of ray i, if it precedes that; returns the t of the first hit.
[[gnu::always_inline]] inline float keep_first(const HitColumns& first, std::size_t i, const HitColumns& of_tile,
                                               std::size_t j, const GlobalIds& ids) {
  if (of_tile.prim[j] < 0) return first.t[i];
  const std::int64_t prim = ids(of_tile.prim[j]);
  if (!precedes(of_tile.t[j], prim, first.t[i], first.prim[i])) return first.t[i];
  first.set(i, {of_tile.t[j], prim, of_tile.u[j], of_tile.distance[j], of_tile.t_out ? of_tile.t_out[j] : kInfinity});
  return first.t[i];
}

/// The first k hits of each of n rays.
class NextHits {
 public:
  NextHits(std::size_t n, std::size_t k) : k_(k), hits_(n * k), n_hits_(n) {}

  /// Adds hits [begin, end) of a tile to those of ray i, and returns its limit.
  float add(std::size_t i, const HitColumns& of_tile, std::size_t begin, std::size_t end, const GlobalIds& ids) {
    Hit* const hits = hits_.data() + i * k_;
    std::uint32_t& n = n_hits_[i];
    for (std::size_t j = begin; j < end; ++j) {
      Hit hit = of_tile[j];
      hit.prim = ids(hit.prim);
      hit.t_out = of_tile.t_out ? of_tile.t_out[j] : kInfinity;
      const auto precedes_hit = [&](const Hit& other) { return precedes(hit.t, hit.prim, other.t, other.prim); };
      if (n == k_ && (n == 0 || !precedes_hit(hits[n - 1]))) break;  // nor do those that follow
      std::size_t at = n < k_ ? n++ : n - 1;
      for (; at > 0 && precedes_hit(hits[at - 1]); --at) hits[at] = hits[at - 1];
      hits[at] = hit;
    }
    return limit(i);
  }

  /// The t beyond which ray i needs no hit.
  float limit(std::size_t i) const {
    return n_hits_[i] < k_ ? kInfinity : k_ == 0 ? -kInfinity : hits_[i * k_ + k_ - 1].t;
  }

  std::size_t n_rays() const { return n_hits_.size(); }
  std::span<const Hit> of(std::size_t i) const { return {hits_.data() + i * k_, n_hits_[i]}; }

 private:
  std::size_t k_;
  LargeVector<Hit> hits_;  // k for each ray, of which n_hits_ are there, sorted
  std::vector<std::uint32_t> n_hits_;
};

}  // namespace fastlines
