// Groups of up to 64 rays, each answered by the kernel that fits_bundle it: as one bundle, as bundles of sixteen, or
// with rays that have nothing to do with each other in a wave or a stream; or one by one, if that is asked for.
//
// What is asked is a query (jobs.hpp): it gives a collector to the kernels, and takes their answers.
#pragma once

#include <limits>

#include "../traverse/bundle_traversal.hpp"
#include "../traverse/ray_stream.hpp"
#include "../traverse/single_ray.hpp"
#include "../traverse/wavefront.hpp"
#include "bundle_heuristic.hpp"

namespace fastlines {

/// Which kernel to use; `automatic` measures how far the rays of each group divergence.
enum class Kernel { automatic, single, wave, bundle };

/// What answers rays that have nothing to do with each other.
template <class Query, RayPrimitive P>
auto make_incoherent_tracer(const WideBvhView<P>& tree, const Query& query) {
  if constexpr (Query::Collector::kTraits.order_independent)
    return RayStream<P>(tree);
  else
    return Wavefront<P, Query>(tree, query);
}

template <RayPrimitive P, class Query>
class GroupDispatcher {
 public:
  GroupDispatcher(const WideBvhView<P>& tree, const RayBatch& batch, Kernel kernel, Query query)
      : query(std::move(query)), tree_(tree), batch_(batch), kernel_(kernel), collector_(this->query.collector()) {}

  /// Answer the rays with these numbers, at most 64; those that go trace_rays may stay unanswered until `flush`.
  void trace(const std::uint32_t* ids, int n) {
    rays_.fill(batch_, tree_.frame, n, ids);
    if (kernel_ == Kernel::single || kernel_ == Kernel::wave) return trace_rays(0, n);
    if (kernel_ == Kernel::automatic) {
      heuristic_.begin_group();
      if (heuristic_.should_probe()) return trace_rays(0, n);
    }
    const int end = round_up_to_width(n);
    if (fits_bundle(0, end)) return trace_bundle(0, end);
    for (int first = 0; first < end; first += kSimdWidth)
      if (fits_bundle(first, first + kSimdWidth))
        trace_bundle(first, first + kSimdWidth);
      else
        trace_rays(first, std::min(first + kSimdWidth, n));
  }

  void flush() {
    if constexpr (!Query::Collector::kTraits.order_independent) {
      incoherent_.flush(query);
      heuristic_.record_single(incoherent_.take_sample());
    }
  }

  Query query;

 private:
  bool fits_bundle(int first, int end) {
    if (!bundle_.try_fit(rays_, first, end, tree_.box)) return false;
    return kernel_ == Kernel::bundle || heuristic_.is_coherent(bundle_.divergence);
  }

  void trace_bundle(int first, int end) {
    end = std::min(end, rays_.n);
    const std::uint64_t most =
        kernel_ == Kernel::bundle ? std::numeric_limits<std::uint64_t>::max() : heuristic_.budget(end - first);
    collector_.begin(rays_, first, end);
    const std::uint64_t cost = bundle_traversal_.search(rays_, bundle_, collector_, most);
    heuristic_.record_bundle({cost, std::uint64_t(end - first)}, bundle_.divergence);
    if (cost > most) return trace_rays(first, end);
    query.store(rays_, collector_, first, end);
  }

  void trace_rays(int first, int end)
    requires(Query::Collector::kTraits.order_independent)
  {
    const int at_once = kernel_ == Kernel::single ? 1 : kGroupSize;
    incoherent_.prepare(rays_, first, end);
    collector_.begin(rays_, first, end);
    for (int i = first; i < end; i += at_once) {
      const int last = std::min(i + at_once, end);
      heuristic_.record_single({incoherent_.search(rays_, i, last, collector_), std::uint64_t(last - i)});
    }
    query.store(rays_, collector_, first, end);
  }

  void trace_rays(int first, int end) {
    if (kernel_ == Kernel::single) return trace_single(first, end);
    for (int i = first; i < end; i += kSimdWidth) incoherent_.add(rays_, i, std::min(i + kSimdWidth, end), query);
    heuristic_.record_single(incoherent_.take_sample());
  }

  void trace_single(int first, int end) {
    collector_.begin(rays_, first, end);
    for (int i = first; i < end; ++i) {
      if (i % kSimdWidth == 0) cull_rays(rays_, i, cull_);
      single_.search(rays_, i, cull_[i % kSimdWidth], collector_);
    }
    query.store(rays_, collector_, first, end);
  }

  const WideBvhView<P>& tree_;
  const RayBatch& batch_;
  Kernel kernel_;
  BundleHeuristic heuristic_{tree_.mean_extent};
  RayGroup rays_;
  RayBundle bundle_;
  CullRay cull_[kSimdWidth];  // of rays that go one by one
  SingleRay<P> single_{tree_};
  BundleTraversal<P> bundle_traversal_{tree_};
  typename Query::Collector collector_;
  decltype(make_incoherent_tracer<Query>(tree_, query)) incoherent_ = make_incoherent_tracer<Query>(tree_, query);
};

}  // namespace fastlines
