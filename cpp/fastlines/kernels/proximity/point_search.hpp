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
#include "point_cull.hpp"

namespace fastlines {

/// The search of a layout, for `PointsQuery`.
template <RayPrimitive P>
class PointSearch {
 public:
  /// Whether a primitive may be reported more than once, by pieces that do not know which of them owns it.
  static constexpr bool kRepeats = !AxisPrimitive<P>;

  const Frame& frame;

  PointSearch(const WideBvhView<P>& tree, std::size_t n_leaves) : frame(tree.frame), tree_(tree), n_leaves_(n_leaves) {}

  /// The most steps that a point may take, for progress.
  std::size_t n_steps() const { return n_leaves_; }

  /// A node with children that wait.
  struct StackFrame {
    alignas(64) float dist2[kSimdWidth];
    std::uint32_t node, waiting;
  };

  struct Scratch {
    std::vector<StackFrame> stack;  ///< only grows
    std::uint32_t last = kNoPrim;   ///< the nearest row of the last point, which is likely near the next one
  };

  template <PointCollector C>
  void operator()(const PointQuery& query, C& to, Scratch& scratch, Checkpoint& checkpoint) const {
    if constexpr (std::same_as<C, NearestOfPoint>)
      if (scratch.last != kNoPrim) test(query, 1, to, [&](std::uint32_t) { return Reference{scratch.last}; });
    std::size_t depth = 0;
    push(0, query, to.limit, scratch, depth);
    while (depth > 0) {
      StackFrame& top = scratch.stack[depth - 1];
      float dist2;
      const std::uint32_t lane = least_lane(top.waiting, FloatX16::load(top.dist2), dist2);
      const float reach = box_reach<P>(query, to.limit);
      if (!(dist2 <= reach * reach)) {
        --depth;
        continue;
      }
      top.waiting &= ~(1u << lane);
      const WideNode& node = tree_.nodes[top.node];
      depth -= top.waiting == 0;
      if (lane < node.n_inner) {
        push(node.first_inner + lane, query, to.limit, scratch, depth);
      } else {
        checkpoint.pass();
        test_leaf(query, tree_.leaves[node.first_leaf + (lane - node.n_inner)], to);
      }
    }
    if constexpr (std::same_as<C, NearestOfPoint>)
      if (to.best.row != kNoPrim) scratch.last = to.best.row;
  }

 private:
  /// Push a node, if the point may be near any of its children.
  [[gnu::always_inline]] void push(std::uint32_t index, const PointQuery& query, float limit, Scratch& scratch,
                                   std::size_t& depth) const {
    count_step(&StepCounters::nodes);
    if (scratch.stack.size() == depth) scratch.stack.resize(2 * depth + 8);
    const WideNode& node = tree_.nodes[index];
    StackFrame& frame = scratch.stack[depth];
    FloatX16 dist2;
    frame.waiting = cull_boxes(query.p, node, node.planes, node.n_children, box_reach<P>(query, limit), dist2);
    dist2.store(frame.dist2);
    frame.node = index;
    depth += frame.waiting != 0;
  }

  template <PointCollector C>
  [[gnu::always_inline]] void test_leaf(const PointQuery& query, const WideLeaf& leaf, C& to) const {
    count_step(&StepCounters::leaves);
    const std::uint32_t near = cull_pieces<P>(query, leaf, to.limit);
    const auto n = std::uint32_t(std::popcount(near));
    count_step(&StepCounters::tests, n);
    if (n == 0) return;
    std::uint32_t refs[kSimdWidth];
    compress_indices(near, leaf.first_ref, refs);
    test(query, n, to, [&](std::uint32_t j) -> Reference { return tree_.refs[refs[j]]; });
  }

  /// Test n pieces, ref_of(0), …, ref_of(n − 1): one by one, or all at once.
  template <PointCollector C, class RefOf>
  [[gnu::always_inline]] void test(const PointQuery& query, std::uint32_t n, C& to, const RefOf& ref_of) const {
    if (n > kMaxScalarTests) return test_packet(query, n, to, ref_of);
    for (std::uint32_t j = 0; j < n; ++j) {
      const Reference ref = ref_of(j);
      const auto found = nearest_point<P>(query, point_fields_of<P>(tree_.items[ref.prim], frame));
      if (found.within) to.add({found.distance, ref.prim, found.s}, ref);
    }
  }

  template <PointCollector C, class RefOf>
  void test_packet(const PointQuery& query, std::uint32_t n, C& to, const RefOf& ref_of) const {
    constexpr int n_floats = sizeof(typename P::Item) / sizeof(float);
    const float* rows[kSimdWidth];
    for (std::uint32_t j = 0; j < kSimdWidth; ++j)
      rows[j] = reinterpret_cast<const float*>(tree_.items + ref_of(std::min(j, n - 1)).prim);
    FloatX16 floats[n_floats];
    transpose_rows(rows, floats);
    const auto found = nearest_point<P>(query, point_fields<P>(floats, frame));
    float distance[kSimdWidth], s[kSimdWidth];
    found.distance.store(distance);
    found.s.store(s);
    std::uint32_t hit = (found.within & (found.distance <= FloatX16(to.limit))).bits() & lane_mask(n);
    for (; hit; hit &= hit - 1) {
      const auto j = std::uint32_t(std::countr_zero(hit));
      const Reference ref = ref_of(j);
      to.add({distance[j], ref.prim, s[j]}, ref);
    }
  }

  /// The most survivors of a leaf for which testing them one by one is faster than as a packet.
  static constexpr std::uint32_t kMaxScalarTests = 2;

  const WideBvhView<P>& tree_;
  std::size_t n_leaves_;
};

}  // namespace fastlines
