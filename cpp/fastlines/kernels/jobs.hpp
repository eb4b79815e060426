// What can be asked of a wide tree, and where the answers go.
//
// A job is one thread's. `begin` readies a collector for the rays in some lanes and `take` takes their answers.
// `kUnordered` says that the collector takes hits in any order, also those of sixteen rays and as many segments, as a
// stream finds them. Without it rays that go alone go to a wave, or are searched one by one.
#pragma once

#include "../query/lists.hpp"
#include "collect.hpp"
#include "leaving.hpp"

namespace fastlines {

/// The first hit of each ray.
template <At at>
struct FirstJob {
  static constexpr bool kUnordered = false;
  using Collector = FirstCollector<at>;
  const WideView& tree;
  HitColumns to;

  Collector collector() const { return {}; }
  void begin(Collector& collector, const RayLanes& rays, int first, int end) const {
    collector.begin(rays, first, end);
  }

  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    constexpr Hit miss;
    float t[kLanes], u[kLanes], distance[kLanes], t_out[kLanes];
    std::int64_t prim[kLanes];
    const double per_scale = rays.per_scale;
    for (int from = first; from < end; from += kWidth)
      for (int i = from; i < from + kWidth; ++i) {  // of no certain number, or with branches, it would not be vectors
        const auto which = std::bit_cast<std::uint32_t>(found.prim[i]);
        const bool hit = which != kNone;
        const float t_ = rays.t_given(i, found.t[i]), distance_ = float(std::sqrt(found.dist2[i]) * per_scale);
        t[i] = hit ? t_ : miss.t;
        u[i] = hit ? found.s[i] : miss.u;
        distance[i] = hit ? distance_ : miss.distance;
        prim[i] = hit ? std::int64_t(which) : miss.prim;
      }
    if constexpr (at == At::surface)
      for (int from = first; from < end; from += kWidth) leave_each(tree, rays, found.prim, from, t_out);
    const HitColumns columns = to;  // a copy, so that nothing written can alias it
    const auto write = [&](int i, auto n) __attribute__((always_inline)) {
      const std::uint32_t at_ = rays.id[i];
      std::copy_n(t + i, n, columns.t + at_);
      std::copy_n(u + i, n, columns.u + at_);
      std::copy_n(distance + i, n, columns.distance + at_);
      std::copy_n(prim + i, n, columns.prim + at_);
      if constexpr (at == At::surface) std::copy_n(t_out + i, n, columns.t_out + at_);
    };
    for (int from = first; from < end; from += kWidth)
      if (rays.in_fours[from / kWidth])  // so all sixteen are rays: one that ends early repeats its last
        for (int i = from; i < from + kWidth; i += 4) write(i, std::integral_constant<int, 4>());
      else
        for (int i = from; i < std::min(from + kWidth, end); ++i) write(i, std::integral_constant<int, 1>());
  }
};

/// Whether each ray hits anything.
struct AnyJob {
  static constexpr bool kUnordered = false;
  using Collector = AnyCollector;
  bool* to;

  Collector collector() const { return {}; }
  void begin(Collector& collector, const RayLanes& rays, int first, int end) const {
    collector.begin(rays, first, end);
  }
  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.found[i];
  }
};

/// How many segments each ray hits.
struct CountJob {
  static constexpr bool kUnordered = true;
  using Collector = CountCollector;
  std::int64_t* to;

  Collector collector() const { return {}; }
  void begin(Collector& collector, const RayLanes& rays, int first, int end) const {
    collector.begin(rays, first, end);
  }
  void take(const RayLanes& rays, const Collector& found, int first, int end) const {
    for (int i = first; i < end; ++i) to[rays.id[i]] = found.n_hits[i];
  }
};

}  // namespace fastlines
