// Collectors of the hits of one ray, in the registers of a thread (kernels/collect has those of 64 rays);
// device_hit_list.hpp has the lists.
//
// A traversal reports each hit of the exact test by `add`; `limit` is the t in the frame beyond which nothing is
// needed. A collector reads no more of a test than its approach at `kAt`.
#pragma once

#include "../rays/hit_order.hpp"
#include "device_primitives.hpp"
#include "records.hpp"

namespace fastlines {

/// Keeps the first hit.
template <At at>
struct FirstHitOfRay {
  static constexpr At kAt = at;
  static constexpr bool kShrinksLimit = true;
  const Ray& ray;
  float limit;
  float t = kInfinity, t_ray = kInfinity, s = 0.0f, dist2 = 0.0f;
  std::uint32_t prim = kNoDevicePrim;

  explicit FirstHitOfRay(const Ray& ray_) : ray(ray_), limit(ray_.t_max) {}

  template <class Test>
  void add(const Test& test, const WideRef& ref) {
    const ClosestApproach<float> approach = approach_at(at, test);
    // Hits that are so close in the frame are compared in units of the caller's ray (FirstHitCollector).
    if (!(approach.t <= t + ray.tie_tolerance)) return;
    const float new_t_ray = ray.t_ray(approach.t);
    if (!(approach.t + ray.tie_tolerance < t) && !precedes(new_t_ray, ref.prim, t_ray, prim)) return;
    t = approach.t;
    t_ray = new_t_ray;
    s = approach.s;
    dist2 = approach.dist2;
    prim = ref.prim;
    limit = min(t + ray.tie_tolerance, ray.t_max);
  }
};

/// Keeps whether there is a hit.
struct AnyHitOfRay {
  static constexpr At kAt = At::closest;
  static constexpr bool kShrinksLimit = false;
  float limit;
  bool found = false;

  explicit AnyHitOfRay(const Ray& ray) : limit(ray.t_max) {}

  template <class Test>
  void add(const Test&, const WideRef&) {
    found = true;
    limit = kNoMoreDeviceHits;
  }
};

/// Counts hits, up to `at_most`; of a primitive in several leaves, perhaps several times.
struct HitCountOfRay {
  static constexpr At kAt = At::closest;
  static constexpr bool kShrinksLimit = false;
  float limit;
  std::uint64_t at_most;
  std::uint64_t n = 0;

  HitCountOfRay(const Ray& ray, std::uint64_t at_most_)
      : limit(at_most_ > 0 ? ray.t_max : kNoMoreDeviceHits), at_most(at_most_) {}

  template <class Test>
  void add(const Test& test, const WideRef& ref) {
    if (n == at_most || !owns(WideRef::begin(ref.s0), WideRef::end(ref.s1), test.closest.s)) return;
    if (++n == at_most) limit = kNoMoreDeviceHits;
  }
};

}  // namespace fastlines
