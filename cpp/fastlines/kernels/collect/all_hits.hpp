// Lists all hits of each ray, sorted by t and then by id; or the k hits that are nearest to it, sorted by distance.
#pragma once

#include <bit>
#include <optional>
#include <vector>

#include "../../parallel/progress.hpp"
#include "../../query/hit_buffer.hpp"
#include "collector.hpp"
#include "exit_points.hpp"
#include "hit_sorter.hpp"

namespace fastlines {

/// Records all hits, in no order. Each packet has one list, so that sorting takes little memory.
struct AllHitsCollector : ChosenAt {
  /// The hits of a packet: t, s and dist2 of the exact test, the lane in the packet, and the primitive.
  struct Hits {
    LargeVector<float> t, s, dist2;
    LargeVector<std::uint32_t> lane, prim;
    std::size_t n = 0;

    /// Append t, s and dist2 of the lanes in `hit`. Returns where the caller has to write lane and prim; there is room
    /// for 16 of each.
    std::size_t append(std::uint32_t hit, const ClosestApproach<FloatX16>& approach) {
      if (t.size() < n + 2 * kSimdWidth) {
        for (auto* floats : {&t, &s, &dist2}) floats->resize(2 * n + 256);
        for (auto* ids : {&lane, &prim}) ids->resize(2 * n + 256);
      }
      compress(hit, approach.t, t.data() + n);
      compress(hit, approach.s, s.data() + n);
      compress(hit, approach.dist2, dist2.data() + n);
      const std::size_t before = n;
      n += std::size_t(std::popcount(hit));
      return before;
    }
  };

  static constexpr QueryTraits kTraits{.order_independent = true};
  alignas(64) float limit[kGroupSize];
  bool limit_changed = false;
  Hits hits[kGroupSize / kSimdWidth];

  explicit AllHitsCollector(At at_) : ChosenAt{at_} {}

  void begin(const RayGroup& rays, int first, int end) {
    begin_limits(rays, first, end, limit);
    for (int i = first / kSimdWidth; i < round_up_to_width(end) / kSimdWidth; ++i) hits[i].n = 0;
  }

  void add_packet(const RayGroup&, int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach,
                  std::uint32_t prim) {
    Hits& of = hits[first / kSimdWidth];
    const std::size_t at = of.append(hit, approach);
    compress_indices(hit, 0, of.lane.data() + at);
    std::fill_n(of.prim.data() + at, kSimdWidth, prim);
  }

  /// Add hits of 16 pairs: ray[i] is a lane counted from `first`, and `prims` holds the bits of the primitives' ids.
  void add_pairs(int first, std::uint32_t hit, const ClosestApproach<FloatX16>& approach, const std::uint32_t* ray,
                 const FloatX16& prims) {
    Hits& of = hits[first / kSimdWidth];
    const std::size_t at = of.append(hit, approach);
    compress(hit, FloatX16::load(as_floats(ray)), reinterpret_cast<float*>(of.lane.data() + at));
    compress(hit, prims, reinterpret_cast<float*>(of.prim.data() + at));
  }
};

/// Sorts all hits of each ray into lists, or keeps the `n_nearest` hits that are nearest to it.
template <RayPrimitive P>
struct AllHitsQuery {
  using Collector = AllHitsCollector;
  HitBuffer lists;
  Checkpoint* checkpoint = nullptr;  ///< passed between the steps of a list, if there is one

  AllHitsQuery(const WideBvhView<P>& tree, At at, std::optional<std::size_t> n_nearest = {})
      : tree_(tree), at_(at), n_nearest_(n_nearest) {}
  Collector collector() const { return Collector(at_); }

  void store(const RayGroup& rays, const Collector& found, int first, int end) {
    for (int i = first; i < end; i = (i / kSimdWidth + 1) * kSimdWidth)
      if (const Collector::Hits& hits = found.hits[i / kSimdWidth]; hits.n > 0)
        list(rays, i, std::min(end, (i / kSimdWidth + 1) * kSimdWidth), hits);
  }

 private:
  const WideBvhView<P>& tree_;
  At at_;
  std::optional<std::size_t> n_nearest_;
  HitBuffer ranked_;         // the hits of a packet by t, of which the nearest are kept
  std::vector<Hit> of_ray_;  // those of one ray
  HitSorter sorter_;
  LargeVector<float> t_, dist2_;  // sorted, in the frame

  /// What converts t of 16 hits to units of the caller's rays. Hit i is of the ray in lane first + lane[i].
  struct RaysOfHits {
    float t_min[kSimdWidth], t_max[kSimdWidth], t_min_ray[kSimdWidth], t_max_ray[kSimdWidth];
    double t0[kSimdWidth], inv_length[kSimdWidth];

    RaysOfHits(const RayGroup& rays, int first, const std::uint32_t* lane) {
      const auto gather = [=](const float* from, float* to) { FloatX16::permute(from + first, lane).store(to); };
      gather(rays.t_min, t_min);
      gather(rays.t_max, t_max);
      gather(rays.t_min_ray, t_min_ray);
      gather(rays.t_max_ray, t_max_ray);
      FloatX16::permute(rays.t0 + first, lane, t0);
      FloatX16::permute(rays.inv_length + first, lane, inv_length);
    }
  };

  /// List the hits of lanes [first, end), which belong to one packet, together. Loops over the hits of single rays
  /// would be short, and their ends mispredicted.
  void list(const RayGroup& rays, int first, int end, const Collector::Hits& found) {
    if (found.n > kMaxBlockHits) throw std::bad_alloc();
    const auto n = std::uint32_t(found.n);
    sorter_.sort(found.lane.data(), found.t.data(), found.prim.data(), n, checkpoint);
    check();
    const ListColumns to = (n_nearest_ ? ranked_ : lists).begin(n);
    if (const std::size_t room = found.n + kSimdWidth; t_.size() < room)
      for (auto* floats : {&t_, &dist2_}) floats->resize(2 * room);
    // Gather the hits in order.
    for_each_index(n, checkpoint, [&](std::uint32_t k) {
      const std::uint32_t j = sorter_[k];
      t_[k] = found.t[j];
      dist2_[k] = found.dist2[j];
      to.u[k] = found.s[j];
      to.prim[k] = found.prim[j];
    });
    store_t_and_distance(rays, first / kSimdWidth * kSimdWidth, found, to, n);
    sort_each_ray(to, n);
    if (n_nearest_) return list_nearest(rays, first, end, to);
    for (int i = first; i < end; ++i) {
      check();
      store_exits(rays, i, to.from(sorter_.begin(i % kSimdWidth)), n_hits(i % kSimdWidth));
      lists.add(rays.id[i], n_hits(i % kSimdWidth));
    }
    lists.end(n_hit_columns(at_));
  }

  /// Copy the nearest hits of each ray from the sorted ones of a packet.
  void list_nearest(const RayGroup& rays, int first, int end, const ListColumns& sorted) {
    std::uint32_t n = 0;
    const auto n_kept = [&](int i) {
      return std::uint32_t(std::min<std::size_t>(n_hits(i % kSimdWidth), *n_nearest_));
    };
    for (int i = first; i < end; ++i) n += n_kept(i);
    ListColumns to = lists.begin(n);
    for (int i = first; i < end; ++i) {
      check();
      const ListColumns from = sorted.from(sorter_.begin(i % kSimdWidth));
      of_ray_.resize(n_hits(i % kSimdWidth));
      for (std::size_t j = 0; j < of_ray_.size(); ++j) of_ray_[j] = from[j];
      keep_nearest(of_ray_);
      for (std::size_t j = 0; j < of_ray_.size(); ++j) to.set(j, of_ray_[j]);
      store_exits(rays, i, to, n_kept(i));
      lists.add(rays.id[i], n_kept(i));
      to = to.from(n_kept(i));
    }
    lists.end(n_hit_columns(at_));
    ranked_.end(0);
    ranked_.clear();
  }

  /// Keep the nearest hits of a ray, sorted by distance.
  void keep_nearest(std::vector<Hit>& hits) const {
    const std::size_t n = std::min(hits.size(), *n_nearest_);
    std::partial_sort(hits.begin(), hits.begin() + std::ptrdiff_t(n), hits.end(),
                      [](const Hit& a, const Hit& b) { return comes_first(Keep::nearest, a, b); });
    hits.resize(n);
  }

  void store_exits(const RayGroup& rays, int i, const ListColumns& of_ray, std::uint32_t n) const {
    if (has_exit(at_)) store_exits_of_ray(tree_, rays, i, of_ray.prim, n, of_ray.t_out);
  }

  void check() {
    if (checkpoint) checkpoint->check();
  }

  /// How many hits the ray in this lane of the packet has.
  std::uint32_t n_hits(int lane) const { return sorter_.begin(lane + 1) - sorter_.begin(lane); }

  /// Write t and distance in units of the caller's rays, 16 at a time. The next ray or column overwrites what is
  /// written past the end.
  void store_t_and_distance(const RayGroup& rays, int first, const Collector::Hits& found, const ListColumns& to,
                            std::uint32_t n) {
    // With few hits, most lanes would be idle if the hits of each ray were converted by themselves.
    constexpr std::uint32_t max_gathered_hits = 8 * kSimdWidth;
    float batch[kSimdWidth];
    if (n <= max_gathered_hits) {
      std::uint32_t lanes[max_gathered_hits] = {};
      for (std::uint32_t k = 0; k < n; ++k) lanes[k] = found.lane[sorter_[k]];
      for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
        const RaysOfHits of(rays, first, lanes + k);
        const float* const t = t_.data() + k;
        for (int i = 0; i < kSimdWidth; ++i)
          batch[i] = to_ray_t(t[i], of.t_min[i], of.t_max[i], of.t_min_ray[i], of.t_max_ray[i], of.t0[i],
                              rays.inv_scale, of.inv_length[i]);
        std::memcpy(to.t + k, batch, sizeof batch);
      }
    } else {
      for (int lane = 0; lane < kSimdWidth; ++lane, check())
        for (std::uint32_t k = sorter_.begin(lane); k < sorter_.begin(lane + 1); k += kSimdWidth) {
          const float* const t = t_.data() + k;
          for (int i = 0; i < kSimdWidth; ++i) batch[i] = rays.t_ray(first + lane, t[i]);
          std::memcpy(to.t + k, batch, sizeof batch);
        }
    }
    for (std::uint32_t k = 0; k < n; k += kSimdWidth) {
      const float* const dist2 = dist2_.data() + k;
      for (int i = 0; i < kSimdWidth; ++i) batch[i] = float(std::sqrt(dist2[i]) * rays.inv_scale);
      std::memcpy(to.distance + k, batch, sizeof batch);
    }
  }

  /// Sort the hits of each ray exactly; most are in order already.
  void sort_each_ray(const ListColumns& hits, std::uint32_t n) {
    constexpr std::uint32_t max_insertions = 32;  // with more descents, sorting is faster than insertion
    std::uint32_t n_left = n_descents(hits, n);
    // A descent from one ray to the next does not count.
    for (int lane = 1; lane < kSimdWidth; ++lane)
      if (const std::uint32_t k = sorter_.begin(lane); sorter_.begin(lane - 1) < k && k < n)
        n_left -= hits.precedes(k, k - 1);
    for (int lane = 0; n_left > 0 && lane < kSimdWidth; ++lane) {
      check();
      const ListColumns of_ray = hits.from(sorter_.begin(lane));
      const std::uint32_t n_out_of_order = n_descents(of_ray, n_hits(lane));
      n_left -= n_out_of_order;
      if (n_out_of_order > 0 && (n_out_of_order > max_insertions || !insert(of_ray, n_hits(lane))))
        sort(of_ray, n_hits(lane));
    }
  }

  /// How many hits precede their predecessor in the list.
  static std::uint32_t n_descents(const ListColumns& hits, std::size_t n) {
    std::uint32_t found = 0;
    for (std::size_t k = 1; k < n; ++k) found += std::uint32_t(hits.precedes(k, k - 1));
    return found;
  }

  /// Insertion sort, 16 hits at a time. Returns false, with hits out of order, if it would take over 4n moves.
  static bool insert(const ListColumns& hits, std::size_t n) {
    std::size_t n_passed = 0;
    for (std::size_t first = 1; first < n; first += kSimdWidth) {
      const std::size_t end = std::min(first + kSimdWidth, n);
      if (n_descents(hits.from(first - 1), end - first + 1) == 0) continue;
      for (std::size_t k = first; k < end; ++k) {
        std::size_t to = k;
        while (to > 0 && hits.precedes(k, to - 1)) --to;
        if (to < k) move(hits, k, to);
        if ((n_passed += k - to) > 4 * n) return false;
      }
    }
    return true;
  }

  /// Move hit i to place j < i; hits from j on move up by one.
  static void move(const ListColumns& hits, std::size_t i, std::size_t j) {
    const auto rotate = [=](auto* column) { std::rotate(column + j, column + i, column + i + 1); };
    rotate(hits.t);
    rotate(hits.prim);
    rotate(hits.u);
    rotate(hits.distance);
  }

  /// Sort the hits of one ray, without t_out.
  static void sort(const ListColumns& hits, std::size_t n) {
    std::vector<Hit> sorted(n);
    for (std::size_t i = 0; i < n; ++i) sorted[i] = hits[i];
    std::sort(sorted.begin(), sorted.end(), [](const Hit& a, const Hit& b) { return comes_first(Keep::all, a, b); });
    for (std::size_t i = 0; i < n; ++i) hits.set(i, sorted[i]);
  }
};

}  // namespace fastlines
