// A job for a whole batch, on all cores.
#pragma once

#include "answer.hpp"
#include "list_jobs.hpp"
#include "order.hpp"

namespace fastlines {

/// Groups [begin, end): one of `of` chunks.
struct Chunk {
  std::size_t index, of, begin, end;
};

/// Answer all rays. Each thread has a copy of the job; gather(job, chunk) is called when it has done a chunk. Which
/// chunk of n comes i-th is which(i, n).
template <class Job, class Which, class Gather>
void run_job(const WideView& tree, const RayBatch& rays, const RayOrder& order, Kernel kernel, const Job& job,
             unsigned n_threads, Progress& progress, Which&& which, Gather&& gather) {
  const std::size_t n_groups = order.n_groups();
  // Large enough that a wave is rarely drained, small enough that threads end together.
  const std::size_t per_chunk = std::clamp<std::size_t>(n_groups / (8 * n_threads), 1, 16);
  const std::size_t n_chunks = (n_groups + per_chunk - 1) / per_chunk;
  for_each_chunk(
      n_chunks, n_threads, progress, [&] { return std::make_unique<Answerer<Job>>(tree, rays, kernel, job); },
      [&](auto& answerer, std::size_t i_chunk) {
        const std::size_t chunk = which(i_chunk, n_chunks);
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
        gather(answerer->job, Chunk{chunk, n_chunks, begin, end});
      });
}

/// A job whose answers go straight to their places.
template <class Job>
void run_job(const WideView& tree, const RayBatch& rays, Kernel kernel, const Job& job, unsigned n_threads,
             Progress& progress) {
  const auto in_turn = [](std::size_t i, std::size_t) { return i; };
  run_job(tree, rays, RayOrder(rays), kernel, job, n_threads, progress, in_turn, [](Job&, const Chunk&) {});
}

template <class Job>
void run_lists(const WideView& tree, const RayBatch& rays, Kernel kernel, const Job& job, unsigned n_threads,
               Progress& progress, PlacedLists& to) {
  const RayOrder order(rays);
  run_job(
      tree, rays, order, kernel, job, n_threads, progress, PlacedLists::spread_first,
      [&](Job& done, const Chunk& chunk) { to.take(chunk.index, chunk.of, order.n_rays_in(chunk.end), done.lists); });
}

}  // namespace fastlines
