// Sinks define each query for one ray: the first hit, any, the number, all, or the k nearest. A search reports every
// segment that passes the exact test to a sink; the sink decides what counts.
//
// A segment can be reported more than once: for each leaf that lists a piece of it. `FirstSink`, `AnySink` and
// `KNearestSink` tolerate that. `AllSink` and `CountSink` accept a hit only from the piece [s0, s1) that owns the s of
// the closest approach, so each hit counts once. A search that tests each segment once reports it as one whole piece.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "../primitives/ray_primitive.hpp"
#include "../rays/hit.hpp"
#include "../rays/spread_ray.hpp"
#include "../references/reference.hpp"

namespace fastlines {

/// A hit as a search reports it: the ray, the exact test, and the reference whose piece led to it.
template <RayPrimitive P>
struct HitContext {
  using Test =
      decltype(P::template test<float>(std::declval<const RayOf<P>&>(), std::declval<const Fields<P, float>&>()));
  const Ray& ray;
  const Test& test;
  const Reference& ref;

  bool owned() const { return owns(ref.s0, ref.s1, test.closest.s); }
};

/// The hit in units of the caller's ray, and its t in the frame.
template <RayPrimitive P>
std::pair<Hit, float> make_hit(const HitContext<P>& context, At at) {
  const auto& [ray, test, ref] = context;
  const ClosestApproach<float> approach = at == At::surface ? test.entry() : test.closest;
  Hit hit;
  hit.t = ray.t_ray(approach.t);
  hit.prim = ref.prim;
  hit.u = approach.s;
  hit.distance = float(std::sqrt(approach.dist2) * ray.inv_scale);
  if (at == At::surface) hit.t_out = ray.t_ray(test.exit());
  return {hit, approach.t};
}

/// Keeps the first hit.
struct FirstSink {
  At at;
  float limit;  ///< t in the frame: no hit beyond it can be the first
  Hit best{};

  FirstSink(At at_, const Ray& ray) : at(at_), limit(ray.t_max) {}
  template <class Context>
  void add(const Context& context) {
    if (at == At::closest && context.test.closest.t > limit) return;
    const auto [hit, t] = make_hit(context, at);
    if (best.prim >= 0 && !(hit < best)) return;
    best = hit;
    limit = std::min(context.ray.t_max, t + context.ray.tie_tolerance);
  }
  bool done() const { return false; }
};

/// Keeps whether there is a hit.
struct AnySink {
  float limit;
  bool found = false;

  explicit AnySink(const Ray& ray) : limit(ray.t_max) {}
  template <class Context>
  void add(const Context&) {
    found = true;
  }
  bool done() const { return found; }
};

/// Counts hits.
struct CountSink {
  float limit;
  std::int64_t n_hits = 0;

  explicit CountSink(const Ray& ray) : limit(ray.t_max) {}
  template <class Context>
  void add(const Context& context) {
    n_hits += context.owned();
  }
  bool done() const { return false; }
};

/// Keeps all hits.
struct AllSink {
  At at;
  float limit;
  std::vector<Hit> hits;  ///< in no order

  AllSink(At at_, const Ray& ray) : at(at_), limit(ray.t_max) {}
  template <class Context>
  void add(const Context& context) {
    if (context.owned()) hits.push_back(make_hit(context, at).first);
  }
  bool done() const { return false; }
};

/// Keeps the k nearest hits. A hit that is reported again is either among them or farther than all of them.
struct KNearestSink {
  At at;
  float limit;
  std::size_t k;
  std::vector<Hit> hits;  ///< a heap, the farthest hit on top

  KNearestSink(At at_, const Ray& ray, std::size_t k_) : at(at_), limit(ray.t_max), k(k_) {}
  template <class Context>
  void add(const Context& context) {
    if (done() || (at == At::closest && context.test.closest.t > limit)) return;
    for (const Hit& hit : hits)
      if (hit.prim == context.ref.prim) return;
    const Hit hit = make_hit(context, at).first;
    if (hits.size() == k) {
      if (!(hit < hits.front())) return;
      std::pop_heap(hits.begin(), hits.end());
      hits.pop_back();
    }
    hits.push_back(hit);
    std::push_heap(hits.begin(), hits.end());
    if (hits.size() == k) limit = context.ray.max_t(hits.front().t);
  }
  bool done() const { return k == 0; }
};

/// A sink of any type. A search that takes one is compiled once for all queries.
template <RayPrimitive P>
class SinkRef {
 public:
  const float& limit;

  template <class Sink>
  explicit SinkRef(Sink& sink)
      : limit(sink.limit), done_(sink.done()), sink_(&sink), add_([](void* to, const HitContext<P>& context) {
          static_cast<Sink*>(to)->add(context);
          return static_cast<Sink*>(to)->done();
        }) {}

  void add(const HitContext<P>& context) { done_ = add_(sink_, context); }
  bool done() const { return done_; }

 private:
  bool done_;
  void* sink_;
  bool (*add_)(void*, const HitContext<P>&);
};

/// Test a ray and a primitive exactly, and report a hit to the sink.
template <RayPrimitive P, class Sink>
void test_primitive(const P& prims, const RayOf<P>& ray, const Frame& frame, const Reference& ref, Sink& sink) {
  const auto test = P::template test<float>(ray, fields_of<P>(prims.item(ref.prim), frame));
  if (test.closest.hit) sink.add(HitContext<P>{ray, test, ref});
}

}  // namespace fastlines
