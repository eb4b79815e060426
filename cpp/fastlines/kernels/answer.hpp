// Groups of up to 64 rays, each answered by the kernel that suits it: as one bundle, as bundles of sixteen, or with
// rays that have nothing to do with each other in a wave or a stream; or one by one, if that is asked for.
//
// What is asked is a job (jobs.hpp): it gives a collector to the kernels, and takes their answers.
#pragma once

#include <limits>

#include "choice.hpp"
#include "single.hpp"
#include "stream.hpp"
#include "thick.hpp"
#include "wave.hpp"

namespace fastlines {

/// Which kernel to use; `automatic` measures how far the rays of each group spread.
enum class Kernel { automatic, single, wave, bundle };

/// What answers rays that have nothing to do with each other.
template <class Job>
auto alone_of(const WideView& tree, const Job& job) {
  if constexpr (Job::kUnordered)
    return Stream(tree);
  else
    return Wave<Job>(tree, job);
}

template <class Job>
class Answerer {
 public:
  Answerer(const WideView& tree, const RayBatch& batch, Kernel kernel, Job job)
      : job(std::move(job)), tree_(tree), batch_(batch), kernel_(kernel), collector_(this->job.collector()) {}

  /// Answer the rays with these numbers, at most 64; those that go alone may stay unanswered until `finish`.
  void take(const std::uint32_t* ids, int n) {
    rays_.fill(batch_, tree_.frame, n, ids);
    if (kernel_ == Kernel::single || kernel_ == Kernel::wave) return alone(0, n);
    if (kernel_ == Kernel::automatic) {
      choice_.next();
      if (choice_.curious()) return alone(0, n);
    }
    const int end = past_sixteen(n);
    if (suits(0, end)) return together(0, end);
    for (int first = 0; first < end; first += kWidth)
      if (suits(first, first + kWidth))
        together(first, first + kWidth);
      else
        alone(first, std::min(first + kWidth, n));
  }

  void finish() {
    if constexpr (!Job::kUnordered) {
      alone_.drain(job);
      choice_.note_alone(alone_.take_work());
    }
  }

  Job job;

 private:
  bool suits(int first, int end) {
    if (!bundle_.gather(rays_, first, end, tree_.box)) return false;
    return kernel_ == Kernel::bundle || choice_.together(bundle_.spread);
  }

  void together(int first, int end) {
    end = std::min(end, rays_.n);
    const std::uint64_t most =
        kernel_ == Kernel::bundle ? std::numeric_limits<std::uint64_t>::max() : choice_.most(end - first);
    job.begin(collector_, rays_, first, end);
    const std::uint64_t cost = thick_.search(rays_, bundle_, collector_, most);
    choice_.note_together({cost, std::uint64_t(end - first)}, bundle_.spread);
    if (cost > most) return alone(first, end);
    job.take(rays_, collector_, first, end);
  }

  void alone(int first, int end)
    requires(Job::kUnordered)
  {
    const int at_once = kernel_ == Kernel::single ? 1 : kLanes;
    alone_.prepare(rays_, first, end);
    job.begin(collector_, rays_, first, end);
    for (int i = first; i < end; i += at_once) {
      const int last = std::min(i + at_once, end);
      choice_.note_alone({alone_.search(rays_, i, last, collector_), std::uint64_t(last - i)});
    }
    job.take(rays_, collector_, first, end);
  }

  void alone(int first, int end) {
    if (kernel_ == Kernel::single) return one_by_one(first, end);
    for (int i = first; i < end; i += kWidth) alone_.add(rays_, i, std::min(i + kWidth, end), job);
    choice_.note_alone(alone_.take_work());
  }

  void one_by_one(int first, int end) {
    job.begin(collector_, rays_, first, end);
    for (int i = first; i < end; ++i) {
      if (i % kWidth == 0) cull_rays(rays_, i, cull_);
      single_.search(rays_, i, cull_[i % kWidth], collector_);
    }
    job.take(rays_, collector_, first, end);
  }

  const WideView& tree_;
  const RayBatch& batch_;
  Kernel kernel_;
  Choice choice_{tree_.mean_extent};
  RayLanes rays_;
  Bundle bundle_;
  CullRay cull_[kWidth];  // of rays that go one by one
  Single single_{tree_};
  ThickSearch thick_{tree_};
  typename Job::Collector collector_;
  decltype(alone_of(tree_, job)) alone_ = alone_of(tree_, job);
};

}  // namespace fastlines
