// Jobs whose answers are lists of hits: all of them, or the nearest few.
#pragma once

#include "hit_order.hpp"
#include "jobs.hpp"

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
    for (int lane = first; lane < end; lane = (lane / kWidth + 1) * kWidth) {
      const AllCollector::Hits& of = found.hits[lane / kWidth];
      if (of.n == 0) continue;
      if (of.n > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();  // 16 rays: over 80 GB
      order_.sort(of.lane.data(), of.t.data(), of.n);
      const std::size_t before = lists.hits.size();
      lists.hits.resize(before + of.n);
      PackedHit* to = lists.hits.data() + before;
      for (int i = lane; i < std::min(end, (lane / kWidth + 1) * kWidth); ++i) {
        const auto of_ray = order_.of(i % kWidth);
        if (of_ray.empty()) continue;
        lists.runs.push_back({rays.id[i], std::uint32_t(of_ray.size())});
        describe(rays, i, of, of_ray, to);
        settle(to, of_ray.size());
        to += of_ray.size();
      }
    }
  }

 private:
  HitOrder order_;

  /// These hits of ray i in the caller's terms, sixteen at a time.
  static void describe(const RayLanes& rays, int i, const AllCollector::Hits& hits,
                       std::span<const std::uint32_t> which, PackedHit* to) {
    float t[kWidth] = {}, distance[kWidth] = {};
    for (; !which.empty(); which = which.subspan(std::min<std::size_t>(which.size(), kWidth))) {
      const int n = int(std::min<std::size_t>(which.size(), kWidth));
      for (int k = 0; k < n; ++k) {
        t[k] = hits.t[which[k]];
        distance[k] = hits.dist2[which[k]];
      }
      for (int k = 0; k < kWidth; ++k) {
        t[k] = rays.t_given(i, t[k]);
        distance[k] = float(std::sqrt(distance[k]) * rays.per_scale);
      }
      for (int k = 0; k < n; ++k) *to++ = {t[k], hits.s[which[k]], distance[k], 0.0f, hits.prim[which[k]]};
    }
  }

  /// Sort hits that stand nearly where they belong.
  static void settle(PackedHit* hits, std::size_t n) {
    constexpr std::size_t kFar = 64;
    for (std::size_t j = 1; j < n; ++j) {
      if (!(hits[j] < hits[j - 1])) continue;
      const PackedHit hit = hits[j];
      std::size_t to = j;
      for (; to > 0 && hit < hits[to - 1]; --to) hits[to] = hits[to - 1];
      hits[to] = hit;
      if (j - to > kFar) return std::sort(hits, hits + n);  // most have much the same t
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
