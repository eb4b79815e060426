// Jobs whose answers are lists of hits: all of them, or the nearest few.
#pragma once

#include <numeric>

#include "hit_order.hpp"
#include "jobs.hpp"
#include "nearest.hpp"

namespace fastlines {

/// Hits of up to 64 rays in one piece of a list: more would take over 40 GB.
inline constexpr std::size_t kMostHits = std::numeric_limits<std::int32_t>::max();

/// Columns that are written of a hit.
template <At at>
inline constexpr std::uint32_t kColumns = at == At::surface ? 5 : 4;

/// All hits of each ray.
template <At at>
struct AllJob {
  static constexpr bool kUnordered = true;
  using Collector = AllCollector<at>;
  HitLists lists;

  explicit AllJob(const WideView& tree) : tree_(tree) {}
  Collector collector() const { return {}; }
  void begin(Collector& collector, const RayLanes& rays, int first, int end) const {
    collector.begin(rays, first, end);
  }

  void take(const RayLanes& rays, const Collector& found, int first, int end) {
    for (int i = first; i < end; i = (i / kWidth + 1) * kWidth)
      if (const typename Collector::Hits& hits = found.hits[i / kWidth]; hits.n > 0)
        list(rays, i, std::min(end, (i / kWidth + 1) * kWidth), hits);
  }

 private:
  const WideView& tree_;
  HitOrder order_;
  LargeVector<float> t_, dist2_;  // in order, of the frame

  /// What tells of sixteen hits how the caller counts t: those of their rays, which are in these lanes from `first` on.
  struct RaysOfHits {
    float t_min[kWidth], t_max[kWidth], t_min_given[kWidth], t_max_given[kWidth];
    double t0[kWidth], per_length[kWidth];

    RaysOfHits(const RayLanes& rays, int first, const std::uint32_t* lane) {
      const auto pick = [=](const float* from, float* to) { Float16::look_up(from + first, lane).store(to); };
      pick(rays.t_min, t_min);
      pick(rays.t_max, t_max);
      pick(rays.t_min_given, t_min_given);
      pick(rays.t_max_given, t_max_given);
      Float16::look_up(rays.t0 + first, lane, t0);
      Float16::look_up(rays.per_length + first, lane, per_length);
    }
  };

  /// List the hits of rays [first, end), all of one sixteen, together: loops over those of one ray would be short, and
  /// where they end guessed wrong.
  void list(const RayLanes& rays, int first, int end, const typename Collector::Hits& found) {
    if (found.n > kMostHits) throw std::bad_alloc();
    const auto n = std::uint32_t(found.n);
    order_.sort(found.lane.data(), found.t.data(), found.prim.data(), n);
    const ListColumns to = lists.begin(n);
    if (const std::size_t room = found.n + kWidth; t_.size() < room)
      for (auto* floats : {&t_, &dist2_}) floats->resize(2 * room);
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t j = order_[k];
      t_[k] = found.t[j];
      dist2_[k] = found.dist2[j];
      to.u[k] = found.s[j];
      to.prim[k] = found.prim[j];
    }
    describe(rays, first / kWidth * kWidth, found, to, n);
    settle(to, n);
    if constexpr (at == At::surface)
      for (int i = first; i < end; ++i) {
        const std::uint32_t begin = order_.begin(i % kWidth);
        leave_all(tree_, rays, i, to.prim + begin, n_hits(i % kWidth), to.t_out + begin);
      }
    for (int i = first; i < end; ++i) lists.add(rays.id[i], n_hits(i % kWidth));
    lists.end(kColumns<at>);
  }

  std::uint32_t n_hits(int lane) const { return order_.begin(lane + 1) - order_.begin(lane); }

  /// t and distance in the caller's terms, sixteen at a time: what is too much is overwritten by the next ray, the next
  /// column.
  void describe(const RayLanes& rays, int first, const typename Collector::Hits& found, const ListColumns& to,
                std::uint32_t n) {
    constexpr std::uint32_t few = 8 * kWidth;  // so few that most of sixteen hits of one ray would be none
    float some[kWidth];
    if (n <= few) {
      std::uint32_t lanes[few] = {};
      for (std::uint32_t k = 0; k < n; ++k) lanes[k] = found.lane[order_[k]];
      for (std::uint32_t k = 0; k < n; k += kWidth) {
        const RaysOfHits of(rays, first, lanes + k);
        const float* const t = t_.data() + k;
        for (int i = 0; i < kWidth; ++i)
          some[i] = given(t[i], of.t_min[i], of.t_max[i], of.t_min_given[i], of.t_max_given[i], of.t0[i],
                          rays.per_scale, of.per_length[i]);
        std::memcpy(to.t + k, some, sizeof some);
      }
    } else {
      for (int lane = 0; lane < kWidth; ++lane)
        for (std::uint32_t k = order_.begin(lane); k < order_.begin(lane + 1); k += kWidth) {
          const float* const t = t_.data() + k;
          for (int i = 0; i < kWidth; ++i) some[i] = rays.t_given(first + lane, t[i]);
          std::memcpy(to.t + k, some, sizeof some);
        }
    }
    for (std::uint32_t k = 0; k < n; k += kWidth) {
      const float* const dist2 = dist2_.data() + k;
      for (int i = 0; i < kWidth; ++i) some[i] = float(std::sqrt(dist2[i]) * rays.per_scale);
      std::memcpy(to.distance + k, some, sizeof some);
    }
  }

  /// Sort the hits of each ray, most of which stand where they belong.
  void settle(const ListColumns& hits, std::uint32_t n) const {
    constexpr std::uint32_t many = 32;  // beyond it, to insert one by one takes longer than to sort
    std::uint32_t left = n_descents(hits, n);
    for (int lane = 1; lane < kWidth; ++lane)  // where another ray begins is none
      if (const std::uint32_t k = order_.begin(lane); order_.begin(lane - 1) < k && k < n)
        left -= hits.before(k, k - 1);
    for (int lane = 0; left > 0 && lane < kWidth; ++lane) {
      const ListColumns of_ray = hits.from(order_.begin(lane));
      const std::uint32_t here = n_descents(of_ray, n_hits(lane));
      left -= here;
      if (here > 0 && (here > many || !insert(of_ray, n_hits(lane)))) sort(of_ray, n_hits(lane));
    }
  }

  /// How many hits belong before the one that stands before them.
  static std::uint32_t n_descents(const ListColumns& hits, std::size_t n) {
    std::uint32_t found = 0;
    for (std::size_t k = 1; k < n; ++k) found += std::uint32_t(hits.before(k, k - 1));
    return found;
  }

  /// Move what stands too late to its place; false if it is too far, and the hits are not in order yet.
  static bool insert(const ListColumns& hits, std::size_t n) {
    std::size_t n_passed = 0;
    for (std::size_t first = 1; first < n; first += kWidth) {
      const std::size_t end = std::min(first + kWidth, n);
      if (n_descents(hits.from(first - 1), end - first + 1) == 0) continue;
      for (std::size_t k = first; k < end; ++k) {
        std::size_t to = k;
        while (to > 0 && hits.before(k, to - 1)) --to;
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

/// The k nearest hits of each ray.
template <At at>
struct NextJob {
  static constexpr bool kUnordered = false;
  using Collector = NextCollector<at>;
  HitLists lists;

  NextJob(const WideView& tree, std::size_t k) : tree_(tree), k_(k) {}
  Collector collector() const { return Collector(k_); }
  void begin(Collector& collector, const RayLanes& rays, int first, int end) const {
    collector.begin(rays, first, end);
  }

  void take(const RayLanes& rays, const Collector& found, int first, int end) {
    std::size_t n = 0;
    for (int i = first; i < end; ++i) n += found.hits[i].n;
    if (n == 0) return;
    if (n > kMostHits) throw std::bad_alloc();
    const ListColumns to = lists.begin(std::uint32_t(n));
    std::size_t begin = 0;
    for (int i = first; i < end; ++i) {
      const Nearest& hits = found.hits[i];
      const ListColumns of_ray = to.from(begin);
      list(rays, hits, of_ray);
      // May be written past its end: it is the last column, and what the next rays have comes later.
      if constexpr (at == At::surface) leave_all(tree_, rays, i, of_ray.prim, hits.n, of_ray.t_out);
      lists.add(rays.id[i], hits.n);
      begin += hits.n;
    }
    lists.end(kColumns<at>);
  }

 private:
  const WideView& tree_;
  std::size_t k_;
  std::vector<std::uint32_t> order_;

  /// In order.
  void list(const RayLanes& rays, const Nearest& nearest, const ListColumns& to) {
    order_.resize(nearest.n);
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t i, std::uint32_t j) {
      return nearest.is_before(nearest.t_given[i], nearest.prim[i], j);
    });
    for (std::uint32_t i = 0; i < nearest.n; ++i) {
      const std::uint32_t j = order_[i];
      to.t[i] = nearest.t_given[j];
      to.u[i] = nearest.s[j];
      to.distance[i] = float(std::sqrt(nearest.dist2[j]) * rays.per_scale);
      to.prim[i] = nearest.prim[j];
    }
  }
};

}  // namespace fastlines
