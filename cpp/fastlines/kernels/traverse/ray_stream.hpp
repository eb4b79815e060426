// Lists and counts all hits of up to 64 incoherent rays as a stream.
//
// Order does not matter, so rays need no stacks: one work list of (node, ray) pairs serves all of them. Runs of one
// test are long, and their memory is prefetched ahead. Leaves collect in a second list, and surviving pieces in one
// list per packet. Survivors are tested exactly, 16 at a time, each against its own ray. Rays pass the root in packets
// of 16 (root_cull.hpp).
//
// Each hit is reported once: that of an axis by the piece that owns it, that of another primitive when it is first
// found.
#pragma once

#include "../../parallel/progress.hpp"
#include "../../query/visited_set.hpp"
#include "../collect/collector.hpp"
#include "../cost/step_cost.hpp"
#include "../cost/step_counters.hpp"
#include "../intersect/load_fields.hpp"
#include "../intersect/root_cull.hpp"
#include "../rays/spread_rays.hpp"
#include "leaf_survivors.hpp"

namespace fastlines {

/// Sizes of batches, in pairs. Larger batches make longer runs of one test; smaller ones stay in cache.
struct RayStreamTuning {
  /// Nodes taken from the list at a time.
  static constexpr std::size_t kNodeBatch = 256;
  /// How many nodes ahead a node is prefetched.
  static constexpr std::size_t kPrefetchDistance = 16;
  /// Leaves that are worth culling before the last node is done.
  static constexpr std::size_t kLeafBatch = 1024;
  /// Survivors of one packet that are worth testing before the last leaf is done.
  static constexpr std::size_t kSurvivorBatch = 256;
};

template <RayPrimitive P>
class RayStream {
 public:
  RayStream(const WideBvhView<P>& tree, Checkpoint& checkpoint) : tree_(tree), checkpoint_(checkpoint), root_(tree) {}

  /// Prepare the rays in lanes [first, end); `first` begins a packet.
  void prepare(const RayGroupOf<P>& rays, int first, int end) {
    for (int i = first; i < end; i += kSimdWidth) {
      const CullRayOf<FloatX16> cull = cull_packet(rays, i);
      transpose(cull, cull_ + i);
      gather_.load(rays, i);
      if (root_.has_inner_only()) pass_root(cull, rays, i);
    }
  }

  /// Report the hits of the rays in lanes [first, end) to the collector. Returns the cost in cycles.
  template <class Collector>
  std::uint64_t search(const RayGroupOf<P>& rays, int first, int end, Collector& collector) {
    cost_ = SingleStepCost::kRay * std::uint64_t(end - first);
    nodes_.clear();
    leaves_.clear();
    survivors_.clear();
    if constexpr (!AxisPrimitive<P>) reported_.clear();
    begin_rays(first, end);
    while (!nodes_.empty()) {
      checkpoint_.pass();
      test_nodes(rays);
      if (leaves_.size() >= Tuning::kLeafBatch) test_leaves(rays, collector);
    }
    test_leaves(rays, collector);
    for (int i = 0; i < kPackets; ++i) test_survivors(rays, i, collector);
    return cost_;
  }

 private:
  using Tuning = RayStreamTuning;
  static constexpr int kPackets = kGroupSize / kSimdWidth;

  /// Find which of the root's children a packet hits.
  void pass_root(const CullRayOf<FloatX16>& cull, const RayGroupOf<P>& rays, int first) {
    RootCull::Hits root_hits;
    root_.template cull<false>(cull, FloatX16::load(rays.t_max + first), root_hits);
    for (int i = 0; i < kSimdWidth; ++i) root_children_[first + i] = root_hits.children_of(i);
  }

  /// List the root's children that each ray hits, or the root.
  void begin_rays(int first, int end) {
    const auto n = std::uint64_t(end - first);
    if (!root_.has_inner_only()) {
      for (int i = first; i < end; ++i) nodes_.push(0, std::uint32_t(i));
      return;
    }
    count_step(&StepCounters::nodes, n);
    cost_ += SingleStepCost::kRoot * n;
    WorkList::Appender nodes = nodes_.appender(n * kSimdWidth);
    for (int i = first; i < end; ++i) nodes.compress(root_children_[i], root_.first_child(), std::uint32_t(i));
    nodes_.commit(nodes);
  }

  /// Take a batch of nodes from the end of the list, so that the list stays short, and cull them.
  void test_nodes(const RayGroupOf<P>& rays) {
    const std::size_t n = std::min(nodes_.size(), Tuning::kNodeBatch), begin = nodes_.size() - n;
    // Copy the batch, because the list grows while the batch is culled.
    batch_.item.assign(nodes_.item.begin() + std::ptrdiff_t(begin), nodes_.item.begin() + std::ptrdiff_t(begin + n));
    batch_.ray.assign(nodes_.ray.begin() + std::ptrdiff_t(begin), nodes_.ray.begin() + std::ptrdiff_t(begin + n));
    nodes_.n = begin;
    count_step(&StepCounters::nodes, n);
    cost_ += SingleStepCost::kNode * n;
    WorkList::Appender nodes = nodes_.appender(n * kSimdWidth), leaves = leaves_.appender(n * kSimdWidth);
    const WideNode* const tree_nodes = tree_.nodes;
    for (std::size_t j = 0; j < n; ++j) {
      if (j + Tuning::kPrefetchDistance < n) prefetch(tree_nodes + batch_.item[j + Tuning::kPrefetchDistance]);
      const WideNode& node = tree_nodes[batch_.item[j]];
      const std::uint32_t ray = batch_.ray[j];
      FloatX16 near;
      const std::uint32_t lanes = cull_node(cull_[ray], node, rays.t_max[ray], near);
      const std::uint32_t inner = lanes & ((1u << node.n_inner) - 1);
      nodes.compress(inner, node.first_inner, ray);
      leaves.compress(lanes ^ inner, node.first_leaf - node.n_inner, ray);
    }
    nodes_.commit(nodes);
    leaves_.commit(leaves);
  }

  template <class Collector>
  void test_leaves(const RayGroupOf<P>& rays, Collector& collector) {
    const std::size_t n = leaves_.size();
    checkpoint_.pass(n);
    count_step(&StepCounters::leaves, n);
    cost_ += SingleStepCost::kLeaf * n;
    survivors_.add(tree_, leaves_, cull_);
    leaves_.clear();
    for (int i = 0; i < kPackets; ++i)
      if (survivors_.lists[i].size() >= Tuning::kSurvivorBatch) test_survivors(rays, i, collector);
  }

  /// Test the survivors of one packet of rays.
  template <class Collector>
  void test_survivors(const RayGroupOf<P>& rays, int i_packet, Collector& collector) {
    WorkList& survivors = survivors_.lists[i_packet];
    const std::size_t n = survivors.size();
    if (n == 0) return;
    survivors.pad();
    const std::uint32_t *const refs = survivors.item.data(), *const ray = survivors.ray.data();
    count_step(&StepCounters::pieces, n);
    count_step(&StepCounters::packets, (n + kSimdWidth - 1) / kSimdWidth);
    cost_ += SingleStepCost::kPacket * ((n + kSimdWidth - 1) / kSimdWidth);
    // Load and prefetch the references.
    pieces_.reserve(n + kSimdWidth);
    for (std::size_t j = 0; j < n; ++j) {
      const WideRef& ref = tree_.refs[refs[j]];
      __builtin_prefetch(tree_.items + ref.prim);
      pieces_.set(j, ref);
    }
    std::fill_n(pieces_.prim.data() + n, kSimdWidth, 0u);  // whole packets are read
    // Test 16 at a time.
    for (std::size_t j = 0; j < n; j += kSimdWidth) {
      const std::uint32_t* const prims = pieces_.prim.data() + j;
      const auto fields = load_fields(tree_, [&](int i) { return prims[i]; });
      const auto gathered = gather_.template gather<FloatX16, kSimdWidth>(rays, i_packet * kSimdWidth, ray + j);
      const auto test = P::template test<FloatX16>(gathered, fields);
      // Keep the hits that the piece owns.
      float s0[kSimdWidth], s1[kSimdWidth];
      for (std::size_t i = 0; i < kSimdWidth; ++i) {
        s0[i] = WideRef::begin(pieces_.s0[j + i]);
        s1[i] = WideRef::end(pieces_.s1[j + i]);
      }
      const auto owned = owns(FloatX16::load(s0), FloatX16::load(s1), test.closest.s);
      std::uint32_t hit = (test.closest.hit & owned).bits() & lane_mask(n - j);
      if constexpr (!AxisPrimitive<P>) hit = new_hits(hit, i_packet, ray + j, prims);
      if (!hit) continue;
      const auto approach = approach_at(collector.at, test);
      hit &= approach.hit.bits();
      collector.add_pairs(i_packet * kSimdWidth, hit, approach, ray + j, FloatX16::load(as_floats(prims)));
    }
    survivors.clear();
  }

  /// Those of 16 hits that are not reported yet.
  std::uint32_t new_hits(std::uint32_t hit, int i_packet, const std::uint32_t* ray, const std::uint32_t* prims) {
    reported_.reserve(kSimdWidth);
    std::uint32_t is_new = 0;
    for (; hit; hit &= hit - 1) {
      const int i = std::countr_zero(hit);
      const std::uint64_t lane = std::uint64_t(i_packet * kSimdWidth) + ray[i];
      is_new |= std::uint32_t(reported_.insert(lane << 32 | prims[i])) << i;
    }
    return is_new;
  }

  /// References as columns.
  struct RefColumns {
    std::vector<std::uint32_t> prim;
    std::vector<std::uint16_t> s0, s1;

    void reserve(std::size_t n) {
      if (prim.size() >= n) return;
      prim.resize(2 * n);
      s0.resize(2 * n);
      s1.resize(2 * n);
    }
    void set(std::size_t at, const WideRef& ref) {
      prim[at] = ref.prim;
      s0[at] = ref.s0;
      s1[at] = ref.s1;
    }
  };

  const WideBvhView<P>& tree_;
  Checkpoint& checkpoint_;
  std::uint64_t cost_ = 0;
  RootCull root_;
  CullRay cull_[kGroupSize];
  std::uint32_t root_children_[kGroupSize];  // a mask of the root's children that each ray hits
  RayGatherOf<P> gather_;
  WorkList nodes_, batch_, leaves_;
  LeafSurvivors<kSimdWidth> survivors_;
  RefColumns pieces_;
  VisitedSetOf<std::uint64_t> reported_;  // pairs of a lane and a primitive; unused for axes
};

}  // namespace fastlines
