// The k nearest hits of 64 rays, in lanes: a collector like those of collect.hpp.
#pragma once

#include <vector>

#include "collect.hpp"

namespace fastlines {

/// The nearest hits of one ray, in no order. The caller's t decides which come first, and where it is the same, the
/// lower id.
struct Nearest {
  std::uint32_t n = 0, worst = 0;  // how many there are; which comes last, once it has been looked for
  std::vector<float> t_given, t, s, dist2;
  std::vector<std::uint32_t> prim;

  /// Whether a hit comes before the jth.
  bool is_before(float t_given_, std::uint32_t prim_, std::uint32_t j) const {
    return t_given_ < t_given[j] || (t_given_ == t_given[j] && prim_ < prim[j]);
  }

  void set(std::uint32_t at, float t_given_, const Approach<float>& approach, std::uint32_t prim_) {
    if (at == t.size()) {
      for (auto* floats : {&t_given, &t, &s, &dist2}) floats->resize(2 * at + kWidth);
      prim.resize(2 * at + kWidth);
    }
    t_given[at] = t_given_;
    t[at] = approach.t;
    s[at] = approach.s;
    dist2[at] = approach.dist2;
    prim[at] = prim_;
  }

  /// Look for the last one, of one at least: sixteen at a time, for which there is always room.
  void find_worst() {
    constexpr float kNever = -std::numeric_limits<float>::infinity();
    Float16 most = kNever;
    for (std::uint32_t j = 0; j < n; j += kWidth)
      most = max(most, choose(first_lanes(n - j), Float16::load(t_given.data() + j), kNever));
    const float last = -least(Float16(0.0f) - most);
    bool found = false;
    for (std::uint32_t j = 0; j < n; j += kWidth) {
      std::uint32_t bits = (Float16(last) <= Float16::load(t_given.data() + j)).bits() & first_lanes(n - j);
      for (; bits; bits &= bits - 1) {
        const std::uint32_t at = j + std::uint32_t(std::countr_zero(bits));
        if (!found || prim[at] > prim[worst]) worst = at;
        found = true;
      }
    }
  }
};

template <At at_>
struct NextCollector {
  static constexpr bool kUnordered = false, kNearestFirst = true, kAsksWhere = true, kOnlyNearest = false;
  static constexpr At kAt = at_;
  alignas(64) float limit[kLanes];
  bool closer = false;
  std::size_t k;
  Nearest hits[kLanes];

  explicit NextCollector(std::size_t k_) : k(k_) {}

  void begin(const RayLanes& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    if (k == 0) std::fill(limit + first, limit + end, kOut);
    for (int i = first; i < end; ++i) hits[i].n = 0;
  }

  void take(const RayLanes& rays, int first, std::uint32_t hit, const Approach<Float16>& approach, std::uint32_t prim) {
    hit &= (approach.t <= Float16::load(limit + first)).bits();
    if (!hit) return;
    float s[kWidth], t[kWidth], dist2[kWidth];
    approach.s.store(s);
    approach.t.store(t);
    approach.dist2.store(dist2);
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      add(rays, first + i, {s[i], t[i], dist2[i], true}, prim);
    }
  }

  void take_one(const RayLanes& rays, int i, const Approach<float>& approach, const Reference& ref) {
    // Each once, by the piece that holds the point of the segment. At t the ray is within its radius of that point, but
    // for rounding (docs/answers.md), so that piece is met before the limit.
    if (!(approach.t <= limit[i]) || !(ref.s0 <= approach.s && approach.s < ref.s1)) return;
    add(rays, i, approach, ref.prim);
  }

 private:
  void add(const RayLanes& rays, int i, const Approach<float>& approach, std::uint32_t prim) {
    Nearest& nearest = hits[i];
    const float t_given = rays.t_given(i, approach.t);
    const bool is_full = nearest.n == k;
    if (is_full && !nearest.is_before(t_given, prim, nearest.worst)) return;
    nearest.set(is_full ? nearest.worst : nearest.n++, t_given, approach, prim);
    if (nearest.n < k) return;
    nearest.find_worst();
    limit[i] = min(nearest.t[nearest.worst] + rays.margin[i], rays.t_max[i]);
    closer = true;
  }
};

}  // namespace fastlines
