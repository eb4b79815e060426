// What can be asked of a wide tree, and where the answers go.
//
// A job is one thread's. `sink` begins a ray that goes alone and `done` takes its answer; `begin` readies the collector
// for a bundle or a stream and `take` takes the answers of its rays. `kUnordered` says that the collector takes hits in
// any order, also those of one ray and sixteen segments, as a stream finds them.
#pragma once

#include "../query/lists.hpp"
#include "collect.hpp"

namespace fastlines {

/// The first hit of each ray, by closest approach.
struct FirstJob {
  static constexpr bool kUnordered = false;
  using Sink = FirstSink;
  using Collector = FirstCollector;
  HitColumns to;

  Collector collector(const WideView&) const { return {}; }
  Sink sink(const Ray& ray) const { return {At::closest, ray}; }
  void done(std::uint32_t id, const Sink& sink) const { to.set(id, sink.best); }
  void begin(Collector& collector, const RayLanes& rays) const { collector.begin(rays); }

  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    float t[kLanes], distance[kLanes];
    for (int i = first; i < end; ++i) {
      t[i] = rays.t_given(i, found.t[i]);
      distance[i] = float(std::sqrt(found.dist2[i]) * rays.per_scale);
    }
    for (int i = first; i < end; ++i) {
      const auto prim = std::bit_cast<std::uint32_t>(found.prim[i]);
      if (prim == kNone)
        to.set(rays.id[i], Hit{});
      else
        to.set(rays.id[i], Hit{t[i], prim, found.s[i], distance[i], 0.0f});
    }
  }
};

/// The first hit of each ray, where it enters the capsule.
struct FirstSurfaceJob {
  static constexpr bool kUnordered = false;
  using Sink = FirstSink;
  using Collector = SinkCollector<Sink>;
  HitColumns to;

  Collector collector(const WideView& tree) const { return Collector(tree); }
  Sink sink(const Ray& ray) const { return {At::surface, ray}; }
  void done(std::uint32_t id, const Sink& sink) const { to.set(id, sink.best); }
  void begin(Collector& collector, const RayLanes& rays) const {
    collector.begin(rays, [&](int i) { return sink(rays.ray(i)); });
  }
  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to.set(rays.id[i], found.sinks[std::size_t(i)].best);
  }
};

/// Whether each ray hits anything.
struct AnyJob {
  static constexpr bool kUnordered = false;
  using Sink = AnySink;
  using Collector = AnyCollector;
  bool* to;

  Collector collector(const WideView&) const { return {}; }
  Sink sink(const Ray& ray) const { return Sink(ray); }
  void done(std::uint32_t id, const Sink& sink) const { to[id] = sink.found; }
  void begin(Collector& collector, const RayLanes& rays) const { collector.begin(rays); }
  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.found[i];
  }
};

/// How many segments each ray hits.
struct CountJob {
  static constexpr bool kUnordered = true;
  using Sink = CountSink;
  using Collector = CountCollector;
  std::int64_t* to;

  Collector collector(const WideView&) const { return {}; }
  Sink sink(const Ray& ray) const { return Sink(ray); }
  void done(std::uint32_t id, const Sink& sink) const { to[id] = sink.n_hits; }
  void begin(Collector& collector, const RayLanes& rays) const { collector.begin(rays); }
  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.n_hits[i];
  }
};

}  // namespace fastlines
