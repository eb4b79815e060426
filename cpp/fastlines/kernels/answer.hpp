// Groups of up to 64 rays, each answered by the kernel that suits it: as one bundle, as bundles of sixteen, or with
// rays that have nothing to do with each other in a wave or a stream.
//
// What is asked is a job (jobs.hpp): it gives a sink to each ray of a wave and a collector to bundles and streams, and
// takes their answers.
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
struct AloneOf {
  using Type = Wave<typename Job::Sink>;
};
template <class Job>
  requires(Job::kUnordered)
struct AloneOf<Job> {
  using Type = Stream;
};

template <class Job>
class Answerer {
 public:
  Answerer(const WideView& tree, const RayBatch& batch, Kernel kernel, Job job)
      : job(std::move(job)), tree_(tree), batch_(batch), kernel_(kernel), collector_(this->job.collector(tree)) {}

  /// Answer the rays with these numbers, at most 64; those that go alone may stay unanswered until `finish`.
  void take(const std::uint32_t* ids, int n) {
    rays_.fill(batch_, tree_.frame, n, ids);
    if (kernel_ == Kernel::single || kernel_ == Kernel::wave) return alone(0, n);
    if (kernel_ == Kernel::automatic) {
      choice_.next();
      if (choice_.curious()) return alone(0, n);
    }
    const int end = (n + kWidth - 1) / kWidth * kWidth;
    if (suits(0, end)) return together(0, end);
    for (int first = 0; first < end; first += kWidth)
      if (suits(first, first + kWidth))
        together(first, first + kWidth);
      else
        alone(first, std::min(first + kWidth, n));
  }

  void finish() {
    if constexpr (!Job::kUnordered) alone_.drain([this](std::uint32_t id, auto& sink) { job.done(id, sink); });
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
    job.begin(collector_, rays_);
    const std::uint64_t cost = thick_.search(rays_, bundle_, collector_, most);
    choice_.note_together({cost, std::uint64_t(end - first)}, bundle_.spread);
    if (cost > most) return alone(first, end);
    job.take(rays_, collector_, first, end);
  }

  void alone(int first, int end)
    requires(Job::kUnordered)
  {
    const int at_once = kernel_ == Kernel::single ? 1 : kLanes;
    for (int i = first; i < end; i += at_once) {
      const int last = std::min(i + at_once, end);
      job.begin(collector_, rays_);
      choice_.note_alone({alone_.search(rays_, i, last, collector_), std::uint64_t(last - i)});
      job.take(rays_, collector_, i, last);
    }
  }

  void alone(int first, int end) {
    for (int i = first; i < end; ++i) {
      const Ray ray = rays_.ray(i);
      auto sink = job.sink(ray);
      if (kernel_ == Kernel::single) {
        search_single(tree_, ray, sink, stack_);
        job.done(rays_.id[i], sink);
      } else {
        alone_.add(ray, sink, rays_.id[i], [this](std::uint32_t id, auto& ended) { job.done(id, ended); });
      }
    }
    choice_.note_alone(alone_.take_work());
  }

  const WideView& tree_;
  const RayBatch& batch_;
  Kernel kernel_;
  Choice choice_{tree_.mean_extent};
  RayLanes rays_;
  Bundle bundle_;
  Stack stack_;
  ThickSearch thick_{tree_};
  typename Job::Collector collector_;
  typename AloneOf<Job>::Type alone_{tree_};
};

}  // namespace fastlines
