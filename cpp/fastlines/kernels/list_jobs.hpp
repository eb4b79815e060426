// Jobs whose answers are lists of hits: all of them, or the nearest few.
#pragma once

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
    // Count, and put each hit into its ray's run, in order: runs are short, and hits come nearly in order.
    std::uint32_t n_hits[kLanes] = {};
    const std::span pending(found.pending.data(), found.n);
    for (const auto& one : pending) ++n_hits[one.lane];
    const std::size_t before = lists.hits.size();
    lists.hits.resize(before + found.n);
    PackedHit *begin[kLanes], *to[kLanes];
    PackedHit* next = lists.hits.data() + before;
    for (int i = first; i < end; ++i) {
      lists.runs.push_back({rays.id[i], n_hits[i]});
      begin[i] = to[i] = next;
      next += n_hits[i];
    }
    for (const auto& one : pending) {
      const auto i = int(one.lane);
      const float distance = float(std::sqrt(one.dist2) * rays.per_scale);
      const PackedHit hit{rays.t_given(i, one.t), one.s, distance, 0.0f, one.prim};
      PackedHit* place = to[i]++;
      if (n_hits[i] <= kShort)
        for (; place > begin[i] && hit < place[-1]; --place) *place = place[-1];
      *place = hit;
    }
    for (int i = first; i < end; ++i)
      if (n_hits[i] > kShort) std::sort(begin[i], to[i]);
  }

 private:
  static constexpr std::uint32_t kShort = 32;
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
