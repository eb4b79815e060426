// Answers a query for a whole batch of rays, in parallel.
#pragma once

#include "../../parallel/parallel_for.hpp"
#include "../../query/hit_assembler.hpp"
#include "../collect/all_hits.hpp"
#include "../collect/any_hit.hpp"
#include "../collect/count_hits.hpp"
#include "../collect/first_hit.hpp"
#include "../collect/gather.hpp"
#include "../collect/k_nearest.hpp"
#include "../rays/ray_tiling.hpp"
#include "group_dispatcher.hpp"

namespace fastlines {

/// Groups [begin, end): the chunk `index` of `n_chunks`.
struct GroupChunk {
  std::size_t index, n_chunks, begin, end;
};

/// Trace all rays. Each thread has a copy of the query, and calls store(query, chunk) after each chunk. The i-th of n
/// chunks to be traced is chunk_order(i, n).
template <RayPrimitive P, class Query, class ChunkOrder, class Store>
void run_batch(const WideBvhView<P>& tree, const RayBatch& rays, const RayTiling& tiling, Kernel kernel,
               const Query& query, unsigned n_threads, Progress& progress, ChunkOrder&& chunk_order, Store&& store) {
  const std::size_t n_groups = tiling.n_groups();
  // Chunks are large, so that wavefronts are rarely drained, but small enough that threads finish together.
  const std::size_t per_chunk = std::clamp<std::size_t>(n_groups / (8 * std::max(1u, n_threads)), 1, 16);
  const std::size_t n_chunks = (n_groups + per_chunk - 1) / per_chunk;
  parallel_for(
      n_chunks, n_threads, progress,
      [&] { return std::make_unique<GroupDispatcher<P, Query>>(tree, rays, kernel, query, progress); },
      [&](auto& dispatcher, std::size_t i_chunk) {
        const std::size_t chunk = chunk_order(i_chunk, n_chunks);
        const std::size_t begin = chunk * per_chunk, end = std::min(n_groups, begin + per_chunk);
        std::uint32_t ids[2][kGroupSize];  // of a group, and of the next one
        int n = tiling.group(begin, ids[begin % 2]);
        for (std::size_t i = begin; i < end; ++i) {
          progress.check();
          const int n_next = i + 1 < end ? tiling.group(i + 1, ids[(i + 1) % 2]) : 0;
          rays.prefetch(ids[(i + 1) % 2], n_next);
          if (n) dispatcher->trace(ids[i % 2], n);
          n = n_next;
        }
        dispatcher->flush();
        store(dispatcher->query, GroupChunk{chunk, n_chunks, begin, end});
      });
}

/// Trace all rays for a query that writes straight to the caller's arrays.
template <RayPrimitive P, class Query>
void run_batch(const WideBvhView<P>& tree, const RayBatch& rays, Kernel kernel, const Query& query, unsigned n_threads,
               Progress& progress) {
  const auto in_order = [](std::size_t i, std::size_t) { return i; };
  run_batch(tree, rays, RayTiling(rays), kernel, query, n_threads, progress, in_order,
            [](Query&, const GroupChunk&) {});
}

/// Trace all rays for a query that lists hits, and assemble the lists.
template <RayPrimitive P, class Query>
void run_lists(const WideBvhView<P>& tree, const RayBatch& rays, Kernel kernel, const Query& query, unsigned n_threads,
               Progress& progress, HitAssembler& to) {
  const RayTiling tiling(rays);
  to.progress = &progress;
  run_batch(tree, rays, tiling, kernel, query, n_threads, progress, HitAssembler::sample_first,
            [&](Query& done, const GroupChunk& chunk) {
              to.add(chunk.index, chunk.n_chunks, tiling.n_rays_in(chunk.end), done.lists);
            });
}

}  // namespace fastlines
