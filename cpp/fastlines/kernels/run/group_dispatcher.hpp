// Hands each group of up to 64 rays to a kernel: coherent rays to one bundle or to bundles of 16, incoherent rays to a
// wavefront or a stream. The caller may also force a kernel, for example one ray at a time.
//
// Bundles test lines, so only primitives around axes are traced as bundles. The rays of others, and rays with a spread,
// count as incoherent.
//
// A query (kernels/collect/collector.hpp) gives the kernels a collector and stores what the collector has found.
#pragma once

#include <limits>

#include "../traverse/bundle_traversal.hpp"
#include "../traverse/ray_stream.hpp"
#include "../traverse/single_ray.hpp"
#include "../traverse/wavefront.hpp"
#include "bundle_heuristic.hpp"
#include "kernel.hpp"

namespace fastlines {

/// The kernel for incoherent rays: a stream if the order of hits does not matter, otherwise a wavefront.
template <class Query, RayPrimitive P>
auto make_incoherent_tracer(const WideBvhView<P>& tree, const Query& query, Checkpoint& checkpoint) {
  if constexpr (Query::Collector::kTraits.order_independent)
    return RayStream<P>(tree, checkpoint);
  else
    return Wavefront<P, Query>(tree, query, checkpoint);
}

/// Traces groups of rays for one query; one per thread.
template <RayPrimitive P, class Query>
class GroupDispatcher {
 public:
  GroupDispatcher(const WideBvhView<P>& tree, const RayBatch& batch, Kernel kernel, Query query, Progress& progress)
      : query(std::move(query)),
        tree_(tree),
        batch_(batch),
        kernel_(kernel),
        checkpoint_(progress),
        collector_(this->query.collector()) {
    single_.checkpoint = &checkpoint_;
    if constexpr (requires { this->query.checkpoint; }) this->query.checkpoint = &checkpoint_;
  }

  /// Trace the rays with these ids, 1 to 64 of them. A wavefront may keep some unanswered until `flush`.
  void trace(const std::uint32_t* ids, int n) {
    rays_.fill(batch_, tree_.frame, n, ids);
    if (kernel_ == Kernel::single || kernel_ == Kernel::wave) return trace_incoherent(0, n);
    trace_by_coherence(n);
  }

  /// Answer all rays that are still in the wavefront.
  void flush() {
    if constexpr (!Query::Collector::kTraits.order_independent) {
      incoherent_.flush(query);
      heuristic_.record_incoherent(incoherent_.take_sample());
    }
  }

  Query query;

 private:
  static constexpr bool kHasBundles = AxisPrimitive<P> && !kHasSpread<P>;
  /// In the place of the bundles that there are not.
  struct NoBundles {
    NoBundles(const WideBvhView<P>&, Checkpoint&) {}
  };

  /// Trace the group as bundles where its rays are coherent.
  void trace_by_coherence(int n) { trace_incoherent(0, n); }
  void trace_by_coherence(int n)
    requires(kHasBundles)
  {
    if (kernel_ == Kernel::automatic) {
      heuristic_.begin_group();
      if (heuristic_.should_probe()) return trace_incoherent(0, n);
    }
    // Try one bundle, then one for each packet.
    const int end = round_up_to_width(n);
    if (fits_bundle(0, end)) return trace_bundle(0, end);
    for (int first = 0; first < end; first += kSimdWidth)
      if (fits_bundle(first, first + kSimdWidth))
        trace_bundle(first, first + kSimdWidth);
      else
        trace_incoherent(first, std::min(first + kSimdWidth, n));
  }

  /// Whether lanes [first, end) are traced as a bundle; `bundle_` is then fitted to them.
  bool fits_bundle(int first, int end) {
    if (!bundle_.try_fit(rays_, first, end, tree_.box)) return false;
    return kernel_ == Kernel::bundle || heuristic_.is_coherent(bundle_.divergence);
  }

  /// Trace lanes [first, end) as `bundle_`, or as incoherent rays once the bundle exceeds its budget.
  void trace_bundle(int first, int end) {
    end = std::min(end, rays_.n);
    const std::uint64_t budget =
        kernel_ == Kernel::bundle ? std::numeric_limits<std::uint64_t>::max() : heuristic_.budget(end - first);
    collector_.begin(rays_, first, end);
    const std::uint64_t cost = bundle_traversal_.search(rays_, bundle_, collector_, budget);
    heuristic_.record_bundle({cost, std::uint64_t(end - first)}, bundle_.divergence);
    if (cost > budget) return trace_incoherent(first, end);
    query.store(rays_, collector_, first, end);
  }

  /// Trace lanes [first, end) as a stream, of one ray at a time if the kernel is `single`.
  void trace_incoherent(int first, int end)
    requires(Query::Collector::kTraits.order_independent)
  {
    const int rays_per_stream = kernel_ == Kernel::single ? 1 : kGroupSize;
    incoherent_.prepare(rays_, first, end);
    collector_.begin(rays_, first, end);
    for (int i = first; i < end; i += rays_per_stream) {
      const int stop = std::min(i + rays_per_stream, end);
      heuristic_.record_incoherent({incoherent_.search(rays_, i, stop, collector_), std::uint64_t(stop - i)});
    }
    query.store(rays_, collector_, first, end);
  }

  /// Add lanes [first, end) to the wavefront, or trace them one by one if the kernel is `single`.
  void trace_incoherent(int first, int end) {
    if (kernel_ == Kernel::single) return trace_single(first, end);
    for (int i = first; i < end; i += kSimdWidth) incoherent_.add(rays_, i, std::min(i + kSimdWidth, end), query);
    heuristic_.record_incoherent(incoherent_.take_sample());
  }

  void trace_single(int first, int end) {
    collector_.begin(rays_, first, end);
    for (int i = first; i < end; ++i) {
      if (i % kSimdWidth == 0) cull_rays(rays_, i, cull_);
      CollectorLane lane(rays_, i, collector_);
      RayCollectorRef collector(lane);
      single_.search(tree_, LaneViewOf<P>(rays_, i), cull_[i % kSimdWidth], collector);
    }
    query.store(rays_, collector_, first, end);
  }

  const WideBvhView<P>& tree_;
  const RayBatch& batch_;
  Kernel kernel_;
  Checkpoint checkpoint_;
  BundleHeuristic heuristic_{tree_.mean_extent};
  RayGroupOf<P> rays_;
  RayBundle bundle_;
  CullRay cull_[kSimdWidth];  // the packet that `trace_single` is in
  SingleRay<P> single_;
  std::conditional_t<kHasBundles, BundleTraversal<P>, NoBundles> bundle_traversal_{tree_, checkpoint_};
  typename Query::Collector collector_;
  decltype(make_incoherent_tracer<Query>(tree_, query, checkpoint_)) incoherent_ =
      make_incoherent_tracer<Query>(tree_, query, checkpoint_);
};

}  // namespace fastlines
