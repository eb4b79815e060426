// Finds the k nearest hits of each ray, sorted by t and then by id.
#pragma once

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "../../parallel/progress.hpp"
#include "../../query/hit_buffer.hpp"
#include "collector.hpp"
#include "exit_points.hpp"

namespace fastlines {

/// The nearest hits of one ray, in no order. They are compared by t in units of the caller's ray, then by id.
struct KNearest {
  std::uint32_t n = 0;      ///< the number of hits
  std::uint32_t worst = 0;  ///< the index of the last hit; valid after `find_worst`
  std::vector<float> t_ray, t, s, dist2;
  std::vector<std::uint32_t> prim;

  /// Whether a hit precedes hit j.
  bool precedes(float t_ray_, std::uint32_t prim_, std::uint32_t j) const {
    return fastlines::precedes(t_ray_, prim_, t_ray[j], prim[j]);
  }

  void set(std::uint32_t at, float t_ray_, const ClosestApproach<float>& approach, std::uint32_t prim_) {
    if (at == t.size()) {
      for (auto* floats : {&t_ray, &t, &s, &dist2}) floats->resize(2 * at + kSimdWidth);
      prim.resize(2 * at + kSimdWidth);
    }
    t_ray[at] = t_ray_;
    t[at] = approach.t;
    s[at] = approach.s;
    dist2[at] = approach.dist2;
    prim[at] = prim_;
  }

  /// Whether a primitive is among the hits.
  bool holds(std::uint32_t prim_) const { return std::find(prim.begin(), prim.begin() + n, prim_) != prim.begin() + n; }

  /// Find the last hit, of at least one. Reads 16 at a time; the vectors always have room for that.
  void find_worst() {
    FloatX16 largest = -kInfinity;
    for (std::uint32_t j = 0; j < n; j += kSimdWidth)
      largest = max(largest, blend(lane_mask(n - j), FloatX16::load(t_ray.data() + j), -kInfinity));
    const float last = reduce_max(largest);
    bool found = false;
    for (std::uint32_t j = 0; j < n; j += kSimdWidth) {
      std::uint32_t bits = (FloatX16(last) <= FloatX16::load(t_ray.data() + j)).bits() & lane_mask(n - j);
      for (; bits; bits &= bits - 1) {
        const std::uint32_t at = j + std::uint32_t(std::countr_zero(bits));
        if (!found || prim[at] > prim[worst]) worst = at;
        found = true;
      }
    }
  }
};

/// Records up to k hits per ray; the limit falls once there are k. With `has_repeats`, a hit may be reported again: it
/// is then among the hits, or farther than all of them.
template <class Where, bool has_repeats = false>
struct KNearestCollector : Where {
  static constexpr QueryTraits kTraits{.shrinks_limit = true};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  std::size_t k;
  KNearest hits[kGroupSize];

  explicit KNearestCollector(std::size_t k_, Where where = {}) : Where(where), k(k_) {}

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    if (k == 0) std::fill(limit + first, limit + end, kNoMoreHits);
    for (int i = first; i < end; ++i) hits[i].n = 0;
  }

  void add_packet(const RayGroup& rays, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                  std::uint32_t prim) {
    hit &= (approach.t <= FloatX16::load(limit + first)).bits();
    if (!hit) return;
    float s[kSimdWidth], t[kSimdWidth], dist2[kSimdWidth];
    approach.s.store(s);
    approach.t.store(t);
    approach.dist2.store(dist2);
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      add(rays, first + i, {s[i], t[i], dist2[i], true}, prim);
    }
  }

  void add_hit(const RayGroup& rays, int i, const ClosestApproach<float>& approach, const Reference& ref) {
    // Report each hit once, from the piece that owns the point of the segment. At t the ray lies within its radius of
    // that point, up to rounding, so that piece is visited before the limit.
    if (!(approach.t <= limit[i]) || !owns(ref.s0, ref.s1, approach.s)) return;
    add(rays, i, approach, ref.prim);
  }

 private:
  void add(const RayGroup& rays, int i, const ClosestApproach<float>& approach, std::uint32_t prim) {
    KNearest& nearest = hits[i];
    if (has_repeats && nearest.holds(prim)) return;
    const float t_ray = rays.t_ray(i, approach.t);
    const bool is_full = nearest.n == k;
    if (is_full && !nearest.precedes(t_ray, prim, nearest.worst)) return;
    nearest.set(is_full ? nearest.worst : nearest.n++, t_ray, approach, prim);
    if (nearest.n < k) return;
    nearest.find_worst();
    limit[i] = min(nearest.t[nearest.worst] + rays.tie_tolerance[i], limit[i]);
    limit_changed = true;
  }
};

/// Sorts the k nearest hits of each ray into lists.
template <RayPrimitive P, class Where>
struct KNearestQuery {
  using Collector = KNearestCollector<Where, !AxisPrimitive<P>>;
  HitBuffer lists;
  Checkpoint* checkpoint = nullptr;  ///< passed before each list, if there is one

  KNearestQuery(const WideBvhView<P>& tree, std::size_t k, Where where = {}) : tree_(tree), k_(k), where_(where) {}
  Collector collector() const { return Collector(k_, where_); }

  void store(const RayGroup& rays, const Collector& found, int first, int end) {
    std::size_t n = 0;
    for (int i = first; i < end; ++i) n += found.hits[i].n;
    if (n == 0) return;
    if (n > kMaxBlockHits) throw std::bad_alloc();
    const ListColumns to = lists.begin(std::uint32_t(n));
    std::size_t begin = 0;
    for (int i = first; i < end; ++i) {
      const KNearest& hits = found.hits[i];
      const ListColumns of_ray = to.from(begin);
      if (checkpoint) checkpoint->check();
      list(rays, hits, of_ray);
      // Writing past the end is safe: t_out is the last column, and the next rays are written later.
      if constexpr (Where::kHasExit) store_exits_of_ray(tree_, rays, i, of_ray.prim, hits.n, of_ray.t_out);
      lists.add(rays.id[i], hits.n);
      begin += hits.n;
    }
    lists.end(n_hit_columns(where_.at));
  }

 private:
  const WideBvhView<P>& tree_;
  std::size_t k_;
  Where where_;
  std::vector<std::uint32_t> order_;

  /// Write the hits of a ray in order.
  void list(const RayGroup& rays, const KNearest& nearest, const ListColumns& to) {
    order_.resize(nearest.n);
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t i, std::uint32_t j) { return nearest.precedes(nearest.t_ray[i], nearest.prim[i], j); });
    for (std::uint32_t i = 0; i < nearest.n; ++i) {
      const std::uint32_t j = order_[i];
      to.t[i] = nearest.t_ray[j];
      to.u[i] = nearest.s[j];
      to.distance[i] = float(std::sqrt(nearest.dist2[j]) * rays.inv_scale);
      to.prim[i] = nearest.prim[j];
    }
  }
};

}  // namespace fastlines
