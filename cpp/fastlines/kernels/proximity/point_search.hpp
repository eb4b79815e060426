// Searches a wide layout for what is near a point, nearest node first.
//
// A stack frame is a node: a mask of the children that wait, nodes and leaves, and the squared distance of each.
// Nothing is sorted: the next child is the minimum of 16 lanes.
#pragma once

#include <vector>

#include "../../parallel/progress.hpp"
#include "../../query/proximity/point_collectors.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/load_fields.hpp"
#include "../intersect/prefetch.hpp"
#include "point_group.hpp"

namespace fastlines {

/// The search of a layout, for `PointsQuery`.
template <RayPrimitive P>
class PointSearch {
 public:
  /// Whether a primitive may be reported more than once, by pieces that do not know which of them owns it.
  static constexpr bool kRepeats = !AxisPrimitive<P>;

  const Frame& frame;

  PointSearch(const WideBvhView<P>& tree, std::size_t n_leaves) : frame(tree.frame), tree_(tree), n_leaves_(n_leaves) {}

  /// Searches for all that is within the radius of each of 16 points.
  using Group = PointGroupSearch<P>;
  Group group() const { return Group(tree_); }

  /// The most steps that a point may take, for progress.
  std::size_t n_steps() const { return n_leaves_; }

  /// A node with children that wait.
  struct StackFrame {
    alignas(64) float dist2[kSimdWidth];
    std::uint32_t node, waiting;
  };

  struct Scratch {
    std::vector<StackFrame> frames;  ///< only grows
    std::uint32_t last = kNoPrim;    ///< the nearest row of the last point, which is likely near the next one
  };

  template <PointCollector C>
  void operator()(const PointQuery& query, C& to, Scratch& scratch, Checkpoint& checkpoint) const {
    const WideBvhView<P> tree = tree_;  // a copy, so that no store can alias it
    if constexpr (std::same_as<C, NearestOfPoint>)
      if (scratch.last != kNoPrim) test_one(tree, query, Reference{scratch.last}, to);
    std::size_t depth = 0;
    const auto push = [&](std::uint32_t index) __attribute__((always_inline)) {
      count_step(&StepCounters::nodes);
      if (scratch.frames.size() == depth) scratch.frames.resize(2 * depth + 8);
      const WideNode& node = tree.nodes[index];
      StackFrame& frame = scratch.frames[depth];
      FloatX16 dist2;
      frame.waiting = cull_boxes(query.p, node, node.planes, node.n_children, box_reach<P>(query, to.limit), dist2);
      dist2.store(frame.dist2);
      frame.node = index;
      depth += frame.waiting != 0;
    };
    push(0);
    while (depth > 0) {
      StackFrame& top = scratch.frames[depth - 1];
      float dist2;
      const std::uint32_t lane = least_lane(top.waiting, FloatX16::load(top.dist2), dist2);
      const float reach = box_reach<P>(query, to.limit);
      if (!(dist2 <= reach * reach)) {
        --depth;
        continue;
      }
      const WideNode& node = tree.nodes[top.node];
      top.waiting &= ~(1u << lane);
      depth -= top.waiting == 0;
      if (lane < node.n_inner) {
        push(node.first_inner + lane);
        continue;
      }
      checkpoint.pass();
      test_leaf(tree, query, tree.leaves[node.first_leaf + (lane - node.n_inner)], to);
    }
    if constexpr (std::same_as<C, NearestOfPoint>)
      if (to.best.row != kNoPrim) scratch.last = to.best.row;
  }

 private:
  /// Test the pieces of a leaf that pass: one by one, or all at once.
  template <PointCollector C>
  [[gnu::always_inline]] static void test_leaf(const WideBvhView<P>& tree, const PointQuery& query,
                                               const WideLeaf& leaf, C& to) {
    count_step(&StepCounters::leaves);
    const std::uint32_t near = cull_pieces<P>(query, leaf, to.limit);
    const auto n = std::uint32_t(std::popcount(near));
    count_step(&StepCounters::tests, n);
    if (n == 0) return;
    std::uint32_t refs[kSimdWidth];
    compress_indices(near, leaf.first_ref, refs);
    if (n > kMaxScalarTests) return test_packet(tree, query, refs, n, to);
    for (std::uint32_t j = 0; j < n; ++j) test_one(tree, query, tree.refs[refs[j]], to);
  }

  template <PointCollector C>
  [[gnu::always_inline]] static void test_one(const WideBvhView<P>& tree, const PointQuery& query, const Reference& ref,
                                              C& to) {
    const auto found = nearest_point<P>(query, point_fields_of<P>(tree.items[ref.prim], tree.frame));
    if (found.within) to.add({found.distance, ref.prim, found.s}, ref);
  }

  template <PointCollector C>
  static void test_packet(const WideBvhView<P>& tree, const PointQuery& query, const std::uint32_t* refs,
                          std::uint32_t n, C& to) {
    constexpr int n_floats = sizeof(typename P::Item) / sizeof(float);
    const float* rows[kSimdWidth];
    for (std::uint32_t j = 0; j < kSimdWidth; ++j)
      rows[j] = reinterpret_cast<const float*>(tree.items + tree.refs[refs[std::min(j, n - 1)]].prim);
    FloatX16 floats[n_floats];
    transpose_rows(rows, floats);
    const auto found = nearest_point<P>(query, point_fields<P>(floats, tree.frame));
    float distance[kSimdWidth], s[kSimdWidth];
    found.distance.store(distance);
    found.s.store(s);
    std::uint32_t hit = (found.within & (found.distance <= FloatX16(to.limit))).bits() & lane_mask(n);
    for (; hit; hit &= hit - 1) {
      const int j = std::countr_zero(hit);
      const Reference ref = tree.refs[refs[j]];
      to.add({distance[j], ref.prim, s[j]}, ref);
    }
  }

  /// The most survivors of a leaf for which testing them one by one is faster than as a packet.
  static constexpr std::uint32_t kMaxScalarTests = 2;

  const WideBvhView<P> tree_;
  std::size_t n_leaves_;
};

}  // namespace fastlines
