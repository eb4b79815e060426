// Jobs whose answers are lists of hits: all of them, or the nearest few.
#pragma once

#include "jobs.hpp"
#include "places.hpp"

namespace fastlines {

/// All hits of each ray, by closest approach.
struct AllJob {
  static constexpr bool kUnordered = true;
  using Sink = AllSink;
  using Collector = AllCollector;
  HitLists lists;

  Collector collector(const WideView&) const { return {}; }
  Sink sink(const Ray& ray) const { return {At::closest, ray}; }
  void done(std::uint32_t id, Sink& sink) { lists.add(id, sink.hits); }
  void begin(Collector& collector, const RayLanes& rays) const { collector.begin(rays); }

  void take(const RayLanes& rays, const Collector& found, int first, int end) {
    if (found.n > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();  // 64 rays: over 80 GB

    // Each ray's hits in a row.
    std::uint32_t begin[kLanes + 1], next[kLanes];
    std::fill(begin + first, begin + end + 1, 0u);
    for (std::size_t j = 0; j < found.n; ++j) ++begin[found.lane[j] + 1];
    for (int i = first; i < end; ++i) {
      next[i] = begin[i];
      begin[i + 1] += begin[i];
    }
    if (order_.size() < found.n) order_.resize(2 * found.n);
    for (std::size_t j = 0; j < found.n; ++j) order_[next[found.lane[j]]++] = std::uint32_t(j);
    const std::size_t before = lists.hits.size();
    lists.hits.resize(before + found.n);
    for (int i = first; i < end; ++i) {
      const std::uint32_t n = begin[i + 1] - begin[i];
      lists.runs.push_back({rays.id[i], n});
      if (n) sort(rays, i, found, order_.data() + begin[i], n, lists.hits.data() + before + begin[i]);
    }
  }

 private:
  std::vector<std::uint32_t> order_;
  Places places_;

  /// The hits of ray i in the caller's terms, sorted.
  void sort(const RayLanes& rays, int i, const Collector& found, const std::uint32_t* of_ray, std::uint32_t n,
            PackedHit* to) {
    float* const t = places_.numbers(n);
    for (std::uint32_t j = 0; j < n; ++j) t[j] = found.t[of_ray[j]];
    for (std::uint32_t j = 0; j < n; j += kWidth)
      for (std::uint32_t k = j; k < j + kWidth; ++k) t[k] = rays.t_given(i, t[k]);
    const std::uint32_t* const place = places_.sort(n);
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t from = of_ray[j];
      const float distance = float(std::sqrt(found.dist2[from]) * rays.per_scale);
      to[place[j]] = {t[j], found.s[from], distance, 0.0f, found.prim[from]};
    }
    // Of equal t the lower id comes first. Two that meet in a point often have the same.
    for (std::uint32_t j = 1; j < n; ++j) {
      if (to[j].t != to[j - 1].t) continue;
      const std::uint32_t first = j - 1;
      while (j < n && to[j].t == to[first].t) ++j;
      std::sort(to + first, to + j);
    }
  }
};

/// Hits that are described one by one: all of them where the ray enters their capsules, or the k nearest.
template <class S>
struct ListJob {
  static constexpr bool kUnordered = false;
  using Sink = S;
  using Collector = SinkCollector<S>;
  At at;
  std::size_t k = 0;
  HitLists lists;

  Collector collector(const WideView& tree) const { return Collector(tree); }
  Sink sink(const Ray& ray) const {
    if constexpr (std::is_same_v<S, NextSink>)
      return {at, ray, k};
    else
      return {at, ray};
  }
  void done(std::uint32_t id, Sink& sink) { lists.add(id, sink.hits); }
  void begin(Collector& collector, const RayLanes& rays) const {
    collector.begin(rays, [&](int i) { return sink(rays.ray(i)); });
  }
  void take(const RayLanes& rays, Collector& found, int first, int end) {
    for (int i = first; i < end; ++i) lists.add(rays.id[i], found.sinks[std::size_t(i)].hits);
  }
};

}  // namespace fastlines
