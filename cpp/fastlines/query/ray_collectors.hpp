// Collectors define each query for one ray: the first hit, any, the number, all, the first k, or the k nearest.
//
// A search reports every piece of a primitive that passes the exact test, and the collector decides what counts. One
// text serves brute force and the searches of binary trees, single rays on a wide layout (kernels/run) and the kernels
// for GPUs (device). So a collector allocates nothing: its caller provides the room for a list.
//
// A primitive can be reported more than once: for each leaf that lists a piece of it. `FirstHitOfRay` and `AnyHitOfRay`
// tolerate that. The others accept a hit only from the piece [s0, s1) that owns the s of the point where t is taken. At
// that t the ray lies within its radius of the point, up to rounding, so the piece is visited before the limit.
#pragma once

#include <cmath>
#include <cstdint>

#include "../primitives/closest_approach.hpp"
#include "../rays/hit.hpp"
#include "../rays/ray.hpp"
#include "../references/reference.hpp"
#include "heap.hpp"

namespace fastlines {

/// The id of no primitive.
inline constexpr std::uint32_t kNoPrim = 0xffff'ffff;

/// The limit of a ray that needs no more hits: below every t.
inline constexpr float kNoMoreHits = -0x1.fffffep127f;

/// Records the hits of one ray.
template <class C>
concept RayCollector = requires(C& collector, const ClosestApproach<float>& approach, const Reference& ref) {
  /// Whether hits lower the limit, so that nearer nodes should be visited first.
  C::kShrinksLimit;
  /// Whether a hit need not be reported if another one is nearer by more than the ray's tie tolerance.
  C::kDropsFarther;
  /// Where t is taken, and which rays hit. Usually from `FixedAt`, `SurfaceAt` or `ChosenAt`.
  collector.at;
  /// A t in the frame: hits beyond it may be reported, but the collector does not need them.
  collector.limit;
  /// Add a hit: its approach at `at`, in the frame, and the piece that led to it.
  collector.add(approach, ref);
};

/// Keeps the first hit.
template <class Where>
struct FirstHitOfRay : Where {
  static constexpr bool kShrinksLimit = true, kDropsFarther = true;
  const Ray& ray;
  float limit;
  float t = kInfinity;  ///< in units of the caller's ray
  float s = 0.0f, dist2 = 0.0f;
  std::uint32_t prim = kNoPrim;

  explicit FirstHitOfRay(const Ray& ray_, Where where = {}) : Where(where), ray(ray_), limit(ray_.limit) {}

  void add(const ClosestApproach<float>& approach, const Reference& ref) {
    if (!(approach.t <= limit)) return;
    const float t_ray = ray.t_ray(approach.t);
    if (!precedes(t_ray, ref.prim, t, prim)) return;
    t = t_ray;
    s = approach.s;
    dist2 = approach.dist2;
    prim = ref.prim;
    limit = min(approach.t + ray.tie_tolerance, limit);
  }

  bool found() const { return prim != kNoPrim; }
  /// The first hit, without its t_out, or a miss.
  Hit hit() const { return found() ? Hit{t, prim, s, ray.distance(dist2)} : Hit{}; }
};

/// Keeps whether there is a hit.
template <class Where = FixedAt<At::closest>>
struct AnyHitOfRay : Where {
  static constexpr bool kShrinksLimit = false, kDropsFarther = false;
  float limit;
  bool found = false;

  explicit AnyHitOfRay(const Ray& ray, Where where = {}) : Where(where), limit(ray.limit) {}

  void add(const ClosestApproach<float>&, const Reference&) {
    found = true;
    limit = kNoMoreHits;
  }
};

/// Counts hits, up to `at_most`. A primitive whose pieces own no hits counts as often as it is reported.
template <class Where = FixedAt<At::closest>>
struct HitCountOfRay : Where {
  static constexpr bool kShrinksLimit = false, kDropsFarther = false;
  float limit;
  std::uint64_t at_most, n = 0;

  explicit HitCountOfRay(const Ray& ray, std::uint64_t at_most_ = ~0ull, Where where = {})
      : Where(where), limit(at_most_ > 0 ? ray.t_max : kNoMoreHits), at_most(at_most_) {}

  void add(const ClosestApproach<float>& approach, const Reference& ref) {
    if (n == at_most || !owns(ref.s0, ref.s1, approach.s)) return;
    if (++n == at_most) limit = kNoMoreHits;
  }
};

/// Which hits a list keeps: all, the first by t, or the nearest to the ray; as many as there is room for.
enum class Keep { all, first, nearest };

/// The order of a ray's hits in a list: by distance of the nearest; else, and at the same distance, by t and then by
/// id.
template <class A, class B>
[[gnu::always_inline]] inline bool comes_first(Keep keep, const A& a, const B& b) {
  if (keep == Keep::nearest && a.distance != b.distance) return a.distance < b.distance;
  return precedes(a.t, a.prim, b.t, b.prim);
}

/// What a list keeps, fixed at compile time.
template <class Where, Keep keep_>
struct FixedList : Where {
  static constexpr Keep keep = keep_;
  static constexpr bool kShrinksLimit = keep_ == Keep::first;
};
/// The same, chosen at run time.
struct ChosenList : ChosenAt {
  static constexpr bool kShrinksLimit = true;
  Keep keep;
};

/// Lists hits, up to `room`. `Store` holds them: `store[i]` is hit i, and `store.set(i, hit)` sets it, also the first
/// beyond the end. A full list is a heap with the last hit on top.
///
/// Primitives without an axis have no pieces that own hits: with `has_repeats`, a ray may find one in several leaves. A
/// list of all hits keeps them, and drops what is repeated in the end. Any other refuses a primitive that it holds:
/// what it has dropped comes after all that it holds, also when it is found again.
template <class Which, class Store, bool has_repeats = false>
class HitListOfRay : public Which {
 public:
  static constexpr bool kDropsFarther = false;
  using Which::keep;
  const Ray& ray;
  float limit;

  HitListOfRay(const Ray& ray_, Which which, Store store, std::uint64_t room)
      : Which(which), ray(ray_), limit(room > 0 ? ray_.limit : kNoMoreHits), store_(store), room_(room) {}

  std::uint64_t size() const { return n_; }
  Hit operator[](std::uint64_t i) const { return store_[i]; }

  void add(const ClosestApproach<float>& approach, const Reference& ref) {
    if (!(approach.t <= limit) || !owns(ref.s0, ref.s1, approach.s)) return;
    if constexpr (has_repeats)
      if (keep != Keep::all && holds(ref.prim)) return;
    const Hit hit{ray.t_ray(approach.t), ref.prim, approach.s, ray.distance(approach.dist2)};
    if (n_ < room_) {
      store_.set(n_++, hit);
      if (n_ < room_ || keep != Keep::first) return;
      become_heap();
    } else {
      if (!is_heap_) become_heap();
      if (!fastlines::comes_first(keep, hit, store_[0])) return;
      store_.set(0, hit);
      sift_down(*this, 0, n_);
    }
    if (keep == Keep::first) limit = min(limit, ray.max_t(store_[0].t));
  }

  /// Sort the hits in place, and keep one of each primitive.
  void finish() {
    if (is_heap_)
      sort_heap(*this, n_);
    else
      sort_list(*this, n_);
    if constexpr (has_repeats)
      if (keep == Keep::all) drop_repeats();
  }

  // What the heap calls.
  bool comes_first(std::uint64_t i, std::uint64_t j) const {
    return fastlines::comes_first(keep, store_[i], store_[j]);
  }
  void swap(std::uint64_t i, std::uint64_t j) {
    const Hit hit = store_[i];
    store_.set(i, store_[j]);
    store_.set(j, hit);
  }

 private:
  bool holds(std::uint32_t prim) const {
    for (std::uint64_t i = 0; i < n_; ++i)
      if (store_[i].prim == std::int64_t(prim)) return true;
    return false;
  }

  void become_heap() {
    make_heap(*this, n_);
    is_heap_ = true;
  }

  /// Keep the first of equal hits, which follow each other.
  void drop_repeats() {
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < n_; ++i)
      if (n == 0 || store_[i].prim != store_[n - 1].prim) store_.set(n++, store_[i]);
    n_ = n;
  }

  Store store_;
  std::uint64_t room_, n_ = 0;
  bool is_heap_ = false;
};

/// A collector of any type. A search that takes one is compiled once for all queries.
class RayCollectorRef {
 public:
  static constexpr bool kShrinksLimit = true, kDropsFarther = false;
  const At at;
  const float& limit;

  template <class C>
  explicit RayCollectorRef(C& collector)
      : at(collector.at),
        limit(collector.limit),
        collector_(&collector),
        add_([](void* to, const ClosestApproach<float>& approach, const Reference& ref) {
          static_cast<C*>(to)->add(approach, ref);
        }) {}

  void add(const ClosestApproach<float>& approach, const Reference& ref) const { add_(collector_, approach, ref); }

 private:
  void* const collector_;
  void (*const add_)(void*, const ClosestApproach<float>&, const Reference&);
};

}  // namespace fastlines
