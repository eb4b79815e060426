// What becomes of the hits of one ray: the first, any, all, or their number. A search shows a sink every segment whose
// box the ray comes near; the sink decides what counts.
//
// A segment can be shown more than once, by each leaf that holds a piece of it. `first` and `any` do not mind. `all`
// and `count` take it only from the piece [s0, s1) that owns the s of the closest approach, so each hit is taken once.
// A search that shows each segment once shows it whole.
#pragma once

#include <cstdint>
#include <vector>

#include "../references/reference.hpp"
#include "exact.hpp"

namespace fastlines {

struct Hit {
  float t = std::numeric_limits<float>::infinity();  // as the caller counts it
  std::int64_t prim = -1;
  float u = 0.0f, distance = std::numeric_limits<float>::infinity();
  float t_out = std::numeric_limits<float>::infinity();

  bool operator<(const Hit& other) const { return t != other.t ? t < other.t : prim < other.prim; }
};

/// A segment within the ray's radius, and all that can be told of it.
struct Found {
  const Ray& ray;
  const Segment& segment;
  const Frame& frame;
  const Approach<float>& approach;
  const Reference& ref;

  bool owned() const { return ref.s0 <= approach.s && approach.s < ref.s1; }
};

/// The hit in the caller's terms, and its t in the frame.
inline std::pair<Hit, float> describe(const Found& found, At at) {
  const Ray& ray = found.ray;
  Hit hit;
  hit.prim = found.ref.prim;
  hit.distance = float(std::sqrt(found.approach.dist2) * ray.per_scale);
  Approach<float> where = found.approach;
  if (at == At::surface) {
    const Seen<float> g = see(ray, found.segment, found.frame);
    where = entry(ray, g, found.approach);
    hit.t_out = ray.t_given(leaving(ray, g));
  }
  hit.u = where.s;
  hit.t = ray.t_given(where.t);
  return {hit, where.t};
}

struct FirstSink {
  At at;
  float limit;  // no hit beyond this t of the frame can win
  Hit best{};

  FirstSink(At at_, const Ray& ray) : at(at_), limit(ray.t_max) {}
  void add(const Found& found) {
    if (at == At::closest && found.approach.t > limit) return;
    const auto [hit, t] = describe(found, at);
    if (best.prim >= 0 && !(hit < best)) return;
    best = hit;
    limit = std::min(found.ray.t_max, t + found.ray.margin);
  }
  bool done() const { return false; }
};

struct AnySink {
  float limit;
  bool found = false;

  explicit AnySink(const Ray& ray) : limit(ray.t_max) {}
  void add(const Found&) { found = true; }
  bool done() const { return found; }
};

struct CountSink {
  float limit;
  std::int64_t n_hits = 0;

  explicit CountSink(const Ray& ray) : limit(ray.t_max) {}
  void add(const Found& found) { n_hits += found.owned(); }
  bool done() const { return false; }
};

struct AllSink {
  At at;
  float limit;
  std::vector<Hit> hits;  // in no order

  AllSink(At at_, const Ray& ray) : at(at_), limit(ray.t_max) {}
  void add(const Found& found) {
    if (found.owned()) hits.push_back(describe(found, at).first);
  }
  bool done() const { return false; }
};

/// The k nearest hits. A hit that is shown again is found among them, or is farther than all of them.
struct NextSink {
  At at;
  float limit;
  std::size_t k;
  std::vector<Hit> hits;  // a heap, the farthest on top

  NextSink(At at_, const Ray& ray, std::size_t k_) : at(at_), limit(ray.t_max), k(k_) {}
  void add(const Found& found) {
    if (done() || (at == At::closest && found.approach.t > limit)) return;
    for (const Hit& hit : hits)
      if (hit.prim == found.ref.prim) return;
    const Hit hit = describe(found, at).first;
    if (hits.size() == k) {
      if (!(hit < hits.front())) return;
      std::pop_heap(hits.begin(), hits.end());
      hits.pop_back();
    }
    hits.push_back(hit);
    std::push_heap(hits.begin(), hits.end());
    if (hits.size() == k) limit = found.ray.beyond(hits.front().t);
  }
  bool done() const { return k == 0; }
};

}  // namespace fastlines
