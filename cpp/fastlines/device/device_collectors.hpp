// Collectors of the hits of one ray, in the registers of a thread (kernels/collect has those of 64 rays).
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
    const ClosestApproach<float> approach = approach_at<at>(test);
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

/// Counts hits, up to `at_most`.
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

/// By what the hits of a list are ranked.
enum class Rank { t, distance };

/// Lists the `room` best hits of a ray, in their place among the lists of all rays. A count has told how many there
/// are, so the list is full in the end. While it is, it is a heap with the last hit on top.
template <At at, Rank rank, bool shrinks_limit>
class HitListOfRay {
 public:
  static constexpr At kAt = at;
  static constexpr bool kShrinksLimit = shrinks_limit;
  const Ray& ray;
  float limit;

  HitListOfRay(const Ray& ray_, const DeviceHits& hits, std::uint64_t first, std::uint64_t room)
      : ray(ray_),
        limit(room > 0 ? ray_.t_max : kNoMoreDeviceHits),
        room_(room),
        t_(hits.t + first),
        u_(hits.u + first),
        distance_(hits.distance + first),
        prim_(hits.prim + first) {}

  std::uint64_t size() const { return n_; }
  std::uint64_t prim(std::uint64_t i) const { return std::uint64_t(prim_[i]); }

  template <class Test>
  void add(const Test& test, const WideRef& ref) {
    const ClosestApproach<float> approach = approach_at<at>(test);
    // The piece that owns the point where t is taken is visited before the limit (docs/answers.md).
    if (!owns(WideRef::begin(ref.s0), WideRef::end(ref.s1), approach.s)) return;
    const float t = ray.t_ray(approach.t), distance = float(std::sqrt(approach.dist2) * ray.inv_scale);
    if (n_ < room_) {
      set(n_++, t, ref.prim, approach.s, distance);
      if (n_ < room_ || !shrinks_limit) return;
      make_heap();
    } else {
      if (!is_heap_) make_heap();
      if (!comes_first(t, ref.prim, distance, 0)) return;
      set(0, t, ref.prim, approach.s, distance);
      sift_down(0, n_);
    }
    if constexpr (shrinks_limit) limit = ray.max_t(t_[0]);
  }

  /// Sort the hits.
  void sort() {
    constexpr std::uint64_t max_insertions = 16;  // hits; a heap is faster beyond, though by how much is not measured
    if (!is_heap_ && n_ <= max_insertions) return sort_by_insertion();
    if (!is_heap_) make_heap();
    for (std::uint64_t end = n_; end > 1;) {
      swap(0, --end);
      sift_down(0, end);
    }
  }

 private:
  bool comes_first(float t, std::int64_t prim, float distance, std::uint64_t j) const {
    if constexpr (rank == Rank::distance)
      if (distance != distance_[j]) return distance < distance_[j];
    return precedes(t, prim, t_[j], prim_[j]);
  }
  bool comes_first(std::uint64_t i, std::uint64_t j) const { return comes_first(t_[i], prim_[i], distance_[i], j); }

  void set(std::uint64_t i, float t, std::int64_t prim, float u, float distance) {
    t_[i] = t;
    prim_[i] = prim;
    u_[i] = u;
    distance_[i] = distance;
  }

  void swap(std::uint64_t i, std::uint64_t j) {
    const float t = t_[i], u = u_[i], distance = distance_[i];
    const std::int64_t prim = prim_[i];
    set(i, t_[j], prim_[j], u_[j], distance_[j]);
    set(j, t, prim, u, distance);
  }

  void sift_down(std::uint64_t parent, std::uint64_t end) {
    for (;;) {
      std::uint64_t child = 2 * parent + 1;
      if (child >= end) return;
      if (child + 1 < end && comes_first(child, child + 1)) ++child;
      if (!comes_first(parent, child)) return;
      swap(parent, child);
      parent = child;
    }
  }

  void make_heap() {
    for (std::uint64_t parent = n_ / 2; parent > 0;) sift_down(--parent, n_);
    is_heap_ = true;
  }

  void sort_by_insertion() {
    for (std::uint64_t i = 1; i < n_; ++i)
      for (std::uint64_t j = i; j > 0 && comes_first(j, j - 1); --j) swap(j, j - 1);
  }

  std::uint64_t room_, n_ = 0;
  bool is_heap_ = false;
  float *t_, *u_, *distance_;
  std::int64_t* prim_;
};

}  // namespace fastlines
