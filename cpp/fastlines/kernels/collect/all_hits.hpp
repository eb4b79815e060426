// All hits of each ray, sorted.
#pragma once

#include <bit>

#include "../../query/hit_buffer.hpp"
#include "collector.hpp"
#include "exit_points.hpp"
#include "hit_sorter.hpp"

namespace fastlines {

/// All hits, in no order; those of sixteen rays together, so that to sort them takes little memory.
template <At at_>
struct AllHitsCollector {
  struct Hits {
    LargeVector<float> t, s, dist2;
    LargeVector<std::uint32_t> lane, prim;
    std::size_t n = 0;

    /// Append all but lane and prim, for which there is room then where they begin.
    std::size_t append(std::uint32_t hit, const ClosestApproach<FloatX16>& approach) {
      if (t.size() < n + 2 * kSimdWidth) {
        for (auto* floats : {&t, &s, &dist2}) floats->resize(2 * n + 256);
        for (auto* numbers : {&lane, &prim}) numbers->resize(2 * n + 256);
      }
      compress(hit, approach.t, t.data() + n);
      compress(hit, approach.s, s.data() + n);
      compress(hit, approach.dist2, dist2.data() + n);
      const std::size_t before = n;
      n += std::size_t(std::popcount(hit));
      return before;
    }
  };

  static constexpr QueryTraits kTraits{.order_independent = true};
  static constexpr At kAt = at_;
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  Hits hits[kGroupSize / kSimdWidth];

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    for (int i = first / kSimdWidth; i < round_up_to_width(end) / kSimdWidth; ++i) hits[i].n = 0;
  }

  void add_packet(const RayGroup&, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                  std::uint32_t prim) {
    Hits& of = hits[first / kSimdWidth];
    const std::size_t at = of.append(hit, approach);
    compress_indices(hit, 0, of.lane.data() + at);
    std::fill_n(of.prim.data() + at, kSimdWidth, prim);
  }

  /// The same for sixteen pairs: of a ray, counted from `first`, and a segment, of which the bits are t_ray.
  void add_pairs(int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach, const std::uint32_t* ray,
                 const FloatX16& prims) {
    Hits& of = hits[first / kSimdWidth];
    const std::size_t at = of.append(hit, approach);
    compress(hit, FloatX16::load(as_floats(ray)), reinterpret_cast<float*>(of.lane.data() + at));
    compress(hit, prims, reinterpret_cast<float*>(of.prim.data() + at));
  }
};

/// All hits of each ray.
template <RayPrimitive P, At at>
struct AllHitsQuery {
  using Collector = AllHitsCollector<at>;
  HitBuffer lists;

  explicit AllHitsQuery(const WideBvhView<P>& tree) : tree_(tree) {}
  Collector collector() const { return {}; }

  void store(const RayGroup& rays, const Collector& found, int first, int end) {
    for (int i = first; i < end; i = (i / kSimdWidth + 1) * kSimdWidth)
      if (const typename Collector::Hits& hits = found.hits[i / kSimdWidth]; hits.n > 0)
        list(rays, i, std::min(end, (i / kSimdWidth + 1) * kSimdWidth), hits);
  }

 private:
  const WideBvhView<P>& tree_;
  HitSorter sorter_;
  LargeVector<float> t_, dist2_;  // in order, of the frame

  /// What tells of sixteen hits how the caller counts t: those of their rays, which are in these lanes from `first` on.
  struct RaysOfHits {
    float t_min[kSimdWidth], t_max[kSimdWidth], t_min_ray[kSimdWidth], t_max_ray[kSimdWidth];
    double t0[kSimdWidth], inv_length[kSimdWidth];

    RaysOfHits(const RayGroup& rays, int first, const std::uint32_t* lane) {
      const auto gather = [=](const float* from, float* to) { FloatX16::permute(from + first, lane).store(to); };
      gather(rays.t_min, t_min);
      gather(rays.t_max, t_max);
      gather(rays.t_min_ray, t_min_ray);
      gather(rays.t_max_ray, t_max_ray);
      FloatX16::permute(rays.t0 + first, lane, t0);
      FloatX16::permute(rays.inv_length + first, lane, inv_length);
    }
  };

  /// List the hits of rays [first, end), all of one sixteen, together: loops over those of one ray would be short, and
  /// where they end guessed wrong.
  void list(const RayGroup& rays, int first, int end, const typename Collector::Hits& found) {
    if (found.n > kMaxBlockHits) throw std::bad_alloc();
    const auto n = std::uint32_t(found.n);
    sorter_.sort(found.lane.data(), found.t.data(), found.prim.data(), n);
    const ListColumns to = lists.begin(n);
    if (const std::size_t room = found.n + kSimdWidth; t_.size() < room)
      for (auto* floats : {&t_, &dist2_}) floats->resize(2 * room);
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t j = sorter_[k];
      t_[k] = found.t[j];
      dist2_[k] = found.dist2[j];
      to.u[k] = found.s[j];
      to.prim[k] = found.prim[j];
    }
    store_t_and_distance(rays, first / kSimdWidth * kSimdWidth, found, to, n);
    sort_each_ray(to, n);
    if constexpr (at == At::surface)
      for (int i = first; i < end; ++i) {
        const std::uint32_t begin = sorter_.begin(i % kSimdWidth);
        store_exit_ts(tree_, rays, i, to.prim + begin, n_hits(i % kSimdWidth), to.t_out + begin);
      }
    for (int i = first; i < end; ++i) lists.add(rays.id[i], n_hits(i % kSimdWidth));
    lists.end(kHitColumns<at>);
  }

  std::uint32_t n_hits(int lane) const { return sorter_.begin(lane + 1) - sorter_.begin(lane); }

  /// t and distance in the caller's terms, sixteen at a time: what is too much is overwritten by the next ray, the next
  /// column.
  void store_t_and_distance(const RayGroup& rays, int first, const typename Collector::Hits& found,
                            const ListColumns& to, std::uint32_t n) {
    constexpr std::uint32_t few = 8 * kSimdWidth;  // so few that most of sixteen hits of one ray would be none
    float some[kSimdWidth];
    if (n <= few) {
      std::uint32_t lanes[few] = {};
      for (std::uint32_t k = 0; k < n; ++k) lanes[k] = found.lane[sorter_[k]];
      for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
        const RaysOfHits of(rays, first, lanes + k);
        const float* const t = t_.data() + k;
        for (int i = 0; i < kSimdWidth; ++i)
          some[i] = to_ray_t(t[i], of.t_min[i], of.t_max[i], of.t_min_ray[i], of.t_max_ray[i], of.t0[i], rays.inv_scale,
                             of.inv_length[i]);
        std::memcpy(to.t + k, some, sizeof some);
      }
    } else {
      for (int lane = 0; lane < kSimdWidth; ++lane)
        for (std::uint32_t k = sorter_.begin(lane); k < sorter_.begin(lane + 1); k += kSimdWidth) {
          const float* const t = t_.data() + k;
          for (int i = 0; i < kSimdWidth; ++i) some[i] = rays.t_ray(first + lane, t[i]);
          std::memcpy(to.t + k, some, sizeof some);
        }
    }
    for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
      const float* const dist2 = dist2_.data() + k;
      for (int i = 0; i < kSimdWidth; ++i) some[i] = float(std::sqrt(dist2[i]) * rays.inv_scale);
      std::memcpy(to.distance + k, some, sizeof some);
    }
  }

  /// Sort the hits of each ray, most of which stand where they belong.
  void sort_each_ray(const ListColumns& hits, std::uint32_t n) const {
    constexpr std::uint32_t many = 32;  // beyond it, to insert one by one takes longer than to sort
    std::uint32_t left = n_descents(hits, n);
    for (int lane = 1; lane < kSimdWidth; ++lane)  // where another ray begins is none
      if (const std::uint32_t k = sorter_.begin(lane); sorter_.begin(lane - 1) < k && k < n)
        left -= hits.precedes(k, k - 1);
    for (int lane = 0; left > 0 && lane < kSimdWidth; ++lane) {
      const ListColumns of_ray = hits.from(sorter_.begin(lane));
      const std::uint32_t here = n_descents(of_ray, n_hits(lane));
      left -= here;
      if (here > 0 && (here > many || !insert(of_ray, n_hits(lane)))) sort(of_ray, n_hits(lane));
    }
  }

  /// How many hits belong before the one that stands before them.
  static std::uint32_t n_descents(const ListColumns& hits, std::size_t n) {
    std::uint32_t found = 0;
    for (std::size_t k = 1; k < n; ++k) found += std::uint32_t(hits.precedes(k, k - 1));
    return found;
  }

  /// Move what stands too late to its place; false if it is too far, and the hits are not in order yet.
  static bool insert(const ListColumns& hits, std::size_t n) {
    std::size_t n_passed = 0;
    for (std::size_t first = 1; first < n; first += kSimdWidth) {
      const std::size_t end = std::min(first + kSimdWidth, n);
      if (n_descents(hits.from(first - 1), end - first + 1) == 0) continue;
      for (std::size_t k = first; k < end; ++k) {
        std::size_t to = k;
        while (to > 0 && hits.precedes(k, to - 1)) --to;
        if (to < k) hits.move(k, to);
        if ((n_passed += k - to) > 4 * n) return false;
      }
    }
    return true;
  }

  static void sort(const ListColumns& hits, std::size_t n) {
    std::vector<Hit> sorted(n);
    for (std::size_t i = 0; i < n; ++i) sorted[i] = {hits.t[i], hits.prim[i], hits.u[i], hits.distance[i]};
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < n; ++i) hits.set(i, sorted[i]);
  }
};

}  // namespace fastlines
