// The list of the hits of one ray, in the memory of the device.
//
// Primitives without an axis have no pieces that own hits, so a ray may find one in several leaves. A list that has
// room for all hits keeps them, and drops what is repeated in the end. A list of the best hits refuses a primitive that
// it holds: what it has dropped comes after all that it holds, also when it is found again.
#pragma once

#include "../rays/hit_order.hpp"
#include "device_heap.hpp"
#include "device_primitives.hpp"
#include "records.hpp"

namespace fastlines {

/// By what the hits of a list are ranked.
enum class Rank { t, distance };

/// Lists the `room` best hits of a ray, in their place among the lists of all rays. A count has told how many there
/// are at most, and without repeats the list is full in the end. While it is, it is a heap with the last hit on top.
template <At at, Rank rank, bool shrinks_limit, bool has_repeats = false>
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
    const ClosestApproach<float> approach = approach_at(at, test);
    // The piece that owns the point where t is taken is visited before the limit, as in kernels/collect/k_nearest.hpp.
    if (!owns(WideRef::begin(ref.s0), WideRef::end(ref.s1), approach.s)) return;
    if constexpr (has_repeats && !kHasRoomForAll)
      if (holds(ref.prim)) return;
    const float t = ray.t_ray(approach.t), distance = float(std::sqrt(approach.dist2) * ray.inv_scale);
    if (n_ < room_) {
      set(n_++, t, ref.prim, approach.s, distance);
      if (n_ < room_ || !shrinks_limit) return;
      become_heap();
    } else {
      if (!is_heap_) become_heap();
      if (!comes_first(t, ref.prim, distance, 0)) return;
      set(0, t, ref.prim, approach.s, distance);
      sift_down(*this, 0, n_);
    }
    if constexpr (shrinks_limit) limit = ray.max_t(t_[0]);
  }

  /// Sort the hits, and keep one of each primitive.
  void finish() {
    if (is_heap_)
      sort_heap(*this, n_);
    else
      sort_list(*this, n_);
    if constexpr (has_repeats && kHasRoomForAll) drop_repeats();
  }

  bool comes_first(std::uint64_t i, std::uint64_t j) const { return comes_first(t_[i], prim_[i], distance_[i], j); }

  void swap(std::uint64_t i, std::uint64_t j) {
    const float t = t_[i], u = u_[i], distance = distance_[i];
    const std::int64_t prim = prim_[i];
    set(i, t_[j], prim_[j], u_[j], distance_[j]);
    set(j, t, prim, u, distance);
  }

 private:
  static constexpr bool kHasRoomForAll = rank == Rank::t && !shrinks_limit;

  bool comes_first(float t, std::int64_t prim, float distance, std::uint64_t j) const {
    if constexpr (rank == Rank::distance)
      if (distance != distance_[j]) return distance < distance_[j];
    return precedes(t, prim, t_[j], prim_[j]);
  }

  bool holds(std::uint32_t prim) const {
    for (std::uint64_t i = 0; i < n_; ++i)
      if (prim_[i] == std::int64_t(prim)) return true;
    return false;
  }

  void set(std::uint64_t i, float t, std::int64_t prim, float u, float distance) {
    t_[i] = t;
    prim_[i] = prim;
    u_[i] = u;
    distance_[i] = distance;
  }

  void become_heap() {
    make_heap(*this, n_);
    is_heap_ = true;
  }

  /// Keep the first of equal hits, which follow each other.
  void drop_repeats() {
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < n_; ++i)
      if (n == 0 || prim_[i] != prim_[n - 1]) set(n++, t_[i], prim_[i], u_[i], distance_[i]);
    n_ = n;
  }

  std::uint64_t room_, n_ = 0;
  bool is_heap_ = false;
  float *t_, *u_, *distance_;
  std::int64_t* prim_;
};

}  // namespace fastlines
