// Searches a wide layout for all that is within a radius of each of 16 points at once. Points are sorted, so those of a
// group are near each other, and need the same nodes.
//
// A node is visited once for all points of the group that may be near it. Its children are culled with the box around
// the group, then each of those that are left with all 16 points; for few points, all 16 children with each of them. In
// a leaf, pieces are culled one point at a time, and pairs of a point and a piece wait until there are 16 of them for
// the exact test.
#pragma once

#include <bit>
#include <new>
#include <vector>

#include "../../parallel/progress.hpp"
#include "../../query/proximity/point_collectors.hpp"
#include "../../simd/transpose.hpp"
#include "../collect/hit_sorter.hpp"
#include "../cost/step_counters.hpp"
#include "point_cull.hpp"

namespace fastlines {

/// Up to 16 points, one in each lane.
struct PointLanes {
  alignas(64) float p[3][kSimdWidth];
  alignas(64) float radius[kSimdWidth], radius2[kSimdWidth], reach2[kSimdWidth];
};

/// Points of a group that are gathered by lane: a `PointView` of FloatX16.
struct GatheredPoints {
  FloatX16 p[3], radius, radius2;
  bool surface;
};
static_assert(PointView<GatheredPoints>);

/// What is within the radius of the points of a group, as columns, in any order.
class GroupColumns {
 public:
  std::vector<float> distance, s;
  std::vector<std::uint32_t> row, lane;

  std::uint32_t size() const { return size_; }
  void clear() { size_ = 0; }

  /// Append the lanes of a packet whose bit is set.
  [[gnu::always_inline]] void add(std::uint32_t hit, FloatX16 of_distance, FloatX16 of_s, const std::uint32_t* of_row,
                                  const std::uint32_t* of_lane) {
    if (hit == 0) return;
    if (const std::size_t least = std::size_t(size_) + kSimdWidth; row.size() < least) grow(least);
    compress(hit, of_distance, distance.data() + size_);
    compress(hit, of_s, s.data() + size_);
    compress(hit, FloatX16::load(as_floats(of_row)), reinterpret_cast<float*>(row.data() + size_));
    compress(hit, FloatX16::load(as_floats(of_lane)), reinterpret_cast<float*>(lane.data() + size_));
    size_ += std::uint32_t(std::popcount(hit));
  }

 private:
  [[gnu::noinline]] void grow(std::size_t least) {
    constexpr std::size_t most = 0xffff'0000;  // the sorter computes with 32 bits
    if (least > most) throw std::bad_alloc();
    const std::size_t room = std::min(2 * least, most);
    for (auto* column : {&distance, &s}) column->resize(room);
    for (auto* column : {&row, &lane}) column->resize(room);
  }

  std::uint32_t size_ = 0;
};

/// Sort a list that is nearly in order: by insertion, or from scratch if that would take over four moves an entry.
inline void sort_nearly_sorted(std::span<Neighbour> list) {
  std::size_t n_moves = 0;
  for (std::size_t i = 1; i < list.size(); ++i)
    for (std::size_t j = i; j > 0 && list[j] < list[j - 1]; --j) {
      if (++n_moves > 4 * list.size()) return std::sort(list.begin(), list.end());
      std::swap(list[j], list[j - 1]);
    }
}

/// The search of a layout for groups of points, for `PointsQuery`.
template <RayPrimitive P>
class PointGroupSearch {
  static constexpr bool kRepeats = !AxisPrimitive<P>;
  /// The most points of a group for which a node is faster culled for each of them.
  static constexpr int kFewPoints = 6;
  /// The fewest entries of lists that take so long to write that a query should be able to end.
  static constexpr std::uint32_t kMany = 1 << 20;

 public:
  explicit PointGroupSearch(const WideBvhView<P>& tree) : tree_(tree) {}

  /// Append the lists of a group of points with these ids, each sorted, and set the length of each.
  void list(std::span<const PointQuery> points, const std::size_t* ids, const Seen& seen, Checkpoint& checkpoint,
            std::vector<Neighbour>& to, std::uint32_t (&lengths)[kSimdWidth]) {
    search(points, ids, seen, checkpoint, nullptr);
    const std::uint32_t n = found_.size();
    if (n > 0) sorter_.sort(found_.lane.data(), found_.distance.data(), found_.row.data(), n, &checkpoint);
    for (std::uint32_t lane = 0; lane < points.size(); ++lane) {
      const std::size_t first = to.size();
      if (n > 0)
        for (std::uint32_t k = sorter_.begin(int(lane)); k < sorter_.begin(int(lane) + 1); ++k) {
          const std::uint32_t j = sorter_[k];
          to.push_back({found_.distance[j], found_.row[j], found_.s[j]});
        }
      if (n >= kMany) checkpoint.check();
      // Those whose distances are closest together may be out of order.
      sort_nearly_sorted(std::span(to).subspan(first));
      remove_repeats(seen, kRepeats, to, first);
      lengths[lane] = std::uint32_t(to.size() - first);
    }
  }

  /// Count the primitives that are near each point, where pieces know which of them owns a primitive.
  void count(std::span<const PointQuery> points, const std::size_t* ids, const Seen& seen, Checkpoint& checkpoint,
             std::uint32_t (&counts)[kSimdWidth]) {
    std::fill(counts, counts + kSimdWidth, 0);
    search(points, ids, seen, checkpoint, counts);
  }

 private:
  /// A node, and the points that may be near it.
  struct Visit {
    std::uint32_t node, lanes;
  };

  /// Find every piece of a primitive that is within the radius of a point, and owns the nearest place. With `counts`
  /// they are counted for each point, and not kept.
  void search(std::span<const PointQuery> points, const std::size_t* ids, const Seen& seen, Checkpoint& checkpoint,
              std::uint32_t* counts) {
    load(points);
    ids_ = ids;
    seen_ = &seen;
    counts_ = counts;
    n_pairs_ = 0;
    found_.clear();
    stack_.assign(1, {0, (1u << points.size()) - 1});
    while (!stack_.empty()) {
      const Visit visit = stack_.back();
      stack_.pop_back();
      count_step(&StepCounters::nodes);
      const WideNode& node = tree_.nodes[visit.node];
      if (std::popcount(visit.lanes) > kFewPoints)
        visit_together(points, node, visit.lanes, checkpoint);
      else
        visit_alone(points, node, visit.lanes, checkpoint);
    }
    test_pairs(1);
  }

  /// Cull the children of a node one by one, each with all points at once.
  [[gnu::always_inline]] void visit_together(std::span<const PointQuery> points, const WideNode& node,
                                             std::uint32_t visiting, Checkpoint& checkpoint) {
    for (std::uint32_t children = cull_group(node); children; children &= children - 1) {
      const int child = std::countr_zero(children);
      const std::uint32_t lanes = cull_points(node, child) & visiting;
      if (lanes == 0) continue;
      if (child < node.n_inner) {
        stack_.push_back({node.first_inner + std::uint32_t(child), lanes});
      } else {
        checkpoint.pass(std::uint64_t(std::popcount(lanes)));
        const WideLeaf& leaf = tree_.leaves[node.first_leaf + std::uint32_t(child - node.n_inner)];
        std::uint32_t n = n_pairs_;  // no store of a reference can alias it
        for (std::uint32_t left = lanes; left; left &= left - 1)
          n += cull_leaf(points, leaf, std::uint32_t(std::countr_zero(left)), n);
        n_pairs_ = n;
        test_pairs(kSimdWidth);
      }
    }
  }

  /// Cull all children of a node at once, for each point.
  [[gnu::always_inline]] void visit_alone(std::span<const PointQuery> points, const WideNode& node,
                                          std::uint32_t visiting, Checkpoint& checkpoint) {
    for (; visiting; visiting &= visiting - 1) {
      const auto lane = std::uint32_t(std::countr_zero(visiting));
      const PointQuery& query = points[lane];
      FloatX16 dist2;
      const std::uint32_t near =
          cull_boxes(query.p, node, node.planes, node.n_children, box_reach<P>(query, query.radius), dist2);
      for (std::uint32_t inner = near & ((1u << node.n_inner) - 1); inner; inner &= inner - 1)
        stack_.push_back({node.first_inner + std::uint32_t(std::countr_zero(inner)), 1u << lane});
      std::uint32_t leaves = near >> node.n_inner;
      checkpoint.pass(std::uint64_t(std::popcount(leaves)));
      std::uint32_t n = n_pairs_;
      for (; leaves; leaves &= leaves - 1)
        n += cull_leaf(points, tree_.leaves[node.first_leaf + std::uint32_t(std::countr_zero(leaves))], lane, n);
      n_pairs_ = n;
      test_pairs(kSimdWidth);
    }
  }

  void load(std::span<const PointQuery> points) {
    surface_ = points[0].surface;
    for (int k = 0; k < 3; ++k) {
      low_[k] = kInfinity;
      high_[k] = -kInfinity;
    }
    for (std::size_t lane = 0; lane < kSimdWidth; ++lane) {
      const PointQuery& query = points[std::min(lane, points.size() - 1)];
      const float reach = box_reach<P>(query, query.radius);
      lanes_.radius[lane] = query.radius;
      lanes_.radius2[lane] = query.radius2;
      lanes_.reach2[lane] = reach * reach;
      for (int k = 0; k < 3; ++k) {
        lanes_.p[k][lane] = query.p[k];
        low_[k] = min(low_[k], query.p[k] - reach);
        high_[k] = max(high_[k], query.p[k] + reach);
      }
    }
  }

  /// A mask of the children that come near the box around the group.
  [[gnu::always_inline]] std::uint32_t cull_group(const WideNode& node) const {
    const float inverse = 1.0f / node.scale;
    auto near = FloatX16(0.0f) <= FloatX16(0.0f);
    for (int k = 0; k < 3; ++k) {
      near = near & (FloatX16::bytes(node.planes + k * kSimdWidth) <= FloatX16((high_[k] - node.org[k]) * inverse));
      near =
          near & (FloatX16((low_[k] - node.org[k]) * inverse) <= FloatX16::bytes(node.planes + (3 + k) * kSimdWidth));
    }
    return near.bits() & ((1u << node.n_children) - 1);
  }

  /// A mask of the points that may be near a child.
  [[gnu::always_inline]] std::uint32_t cull_points(const WideNode& node, int child) const {
    FloatX16 dist2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float low = node.org[k] + float(node.planes[k * kSimdWidth + child]) * node.scale;
      const float high = node.org[k] + float(node.planes[(3 + k) * kSimdWidth + child]) * node.scale;
      const FloatX16 p = FloatX16::load(lanes_.p[k]);
      const FloatX16 beyond = max(max(FloatX16(low) - p, p - FloatX16(high)), FloatX16(0.0f));
      dist2 = fma(beyond, beyond, dist2);
    }
    return (dist2 <= FloatX16::load(lanes_.reach2)).bits();
  }

  /// Write the pairs of a point and the pieces of a leaf that pass from pair n on, and return their number.
  [[gnu::always_inline]] std::uint32_t cull_leaf(std::span<const PointQuery> points, const WideLeaf& leaf,
                                                 std::uint32_t lane, std::uint32_t n) {
    count_step(&StepCounters::leaves);
    const PointQuery& query = points[lane];
    const std::uint32_t near = cull_pieces<P>(query, leaf, query.radius);
    compress_indices(near, leaf.first_ref, refs_ + n);
    std::fill_n(lane_ + n, kSimdWidth, lane);
    return std::uint32_t(std::popcount(near));
  }

  /// Test pairs, 16 at a time, until fewer than `least` are left.
  void test_pairs(std::uint32_t least) {
    std::uint32_t at = 0;
    for (; at < n_pairs_ && n_pairs_ - at >= least; at += kSimdWidth)
      test_packet(refs_ + at, lane_ + at, std::min(n_pairs_ - at, std::uint32_t(kSimdWidth)));
    if (at == 0) return;
    at = std::min(at, n_pairs_);
    std::copy(refs_ + at, refs_ + n_pairs_, refs_);
    std::copy(lane_ + at, lane_ + n_pairs_, lane_);
    n_pairs_ -= at;
  }

  void test_packet(const std::uint32_t* refs, std::uint32_t* lane, std::uint32_t n) {
    count_step(&StepCounters::tests, n);
    std::uint32_t prims[kSimdWidth];
    float begin[kSimdWidth], end[kSimdWidth];
    const float* rows[kSimdWidth];
    for (std::uint32_t j = 0; j < kSimdWidth; ++j) {
      const Reference ref = tree_.refs[refs[std::min(j, n - 1)]];
      prims[j] = ref.prim;
      begin[j] = ref.s0;
      end[j] = ref.s1;
      rows[j] = reinterpret_cast<const float*>(tree_.items + ref.prim);
    }
    std::fill(lane + n, lane + kSimdWidth, 0);
    FloatX16 floats[sizeof(typename P::Item) / sizeof(float)];
    transpose_rows(rows, floats);
    const auto gather = [lane](const float* from) { return FloatX16::permute(from, lane); };
    const GatheredPoints points{{gather(lanes_.p[0]), gather(lanes_.p[1]), gather(lanes_.p[2])},
                                gather(lanes_.radius),
                                gather(lanes_.radius2),
                                surface_};
    const auto found = nearest_point<P>(points, point_fields<P>(floats, tree_.frame));
    std::uint32_t hit = found.within.bits() & lane_mask(n);
    if constexpr (AxisPrimitive<P>) hit &= owns(FloatX16::load(begin), FloatX16::load(end), found.s).bits();
    if (!seen_->sees_all())
      for (std::uint32_t left = hit; left; left &= left - 1) {
        const int j = std::countr_zero(left);
        if (!seen_->sees(ids_[lane[j]], prims[j])) hit &= ~(1u << j);
      }
    if (!counts_) return found_.add(hit, found.distance, found.s, prims, lane);
    for (; hit; hit &= hit - 1) ++counts_[lane[std::countr_zero(hit)]];
  }

  const WideBvhView<P> tree_;
  PointLanes lanes_;
  bool surface_ = false;
  float low_[3], high_[3];  // the box around the group, grown by the reach of its points
  std::vector<Visit> stack_;
  const std::size_t* ids_ = nullptr;
  const Seen* seen_ = nullptr;
  std::uint32_t* counts_ = nullptr;
  GroupColumns found_;
  HitSorter sorter_;
  std::uint32_t n_pairs_ = 0;
  // Pairs to be tested: up to 15 of earlier leaves, those of 16 points and a leaf, and 16 for stores of whole packets.
  std::uint32_t refs_[kSimdWidth * (kSimdWidth + 2)], lane_[kSimdWidth * (kSimdWidth + 2)];
};

}  // namespace fastlines
