// A job for a whole batch, on all cores.
#pragma once

#include "answer.hpp"
#include "list_jobs.hpp"
#include "order.hpp"

namespace fastlines {

/// Answer all rays. Each thread has a copy of the job; gather(job, chunk) is called when it has done a chunk.
template <class Job, class Gather>
void run_job(const WideView& tree, const RayBatch& rays, const RayOrder& order, Kernel kernel, const Job& job,
             unsigned n_threads, Progress& progress, Gather&& gather) {
  const std::size_t n_groups = order.n_groups();
  // Large enough that a wave is rarely drained, small enough that threads end together.
  const std::size_t per_chunk = std::clamp<std::size_t>(n_groups / (8 * n_threads), 1, 16);
  for_each_chunk((n_groups + per_chunk - 1) / per_chunk, n_threads, progress,
                 [&] { return std::make_unique<Answerer<Job>>(tree, rays, kernel, job); },
                 [&](auto& answerer, std::size_t chunk) {
                   const std::size_t begin = chunk * per_chunk, end = std::min(n_groups, begin + per_chunk);
                   std::uint32_t ids[2][kLanes];  // those of one group, and of the next
                   int n = order.group(begin, ids[begin % 2]);
                   for (std::size_t i = begin; i < end; ++i) {
                     progress.check();
                     const int n_next = i + 1 < end ? order.group(i + 1, ids[(i + 1) % 2]) : 0;
                     rays.fetch(ids[(i + 1) % 2], n_next);
                     if (n) answerer->take(ids[i % 2], n);
                     n = n_next;
                   }
                   answerer->finish();
                   gather(answerer->job, chunk);
                 });
}

template <class Job, class Gather>
void run_job(const WideView& tree, const RayBatch& rays, Kernel kernel, const Job& job, unsigned n_threads,
             Progress& progress, Gather&& gather) {
  run_job(tree, rays, RayOrder(rays), kernel, job, n_threads, progress, gather);
}

template <class Job>
PendingLists run_lists(const WideView& tree, const RayBatch& rays, Kernel kernel, const Job& job, unsigned n_threads,
                       Progress& progress) {
  const RayOrder order(rays);
  PendingLists pending(rays.size(), order.n_groups());
  run_job(tree, rays, order, kernel, job, n_threads, progress,
          [&](Job& done, std::size_t chunk) { pending.take(chunk, done.lists); });
  pending.finish();
  return pending;
}

}  // namespace fastlines
