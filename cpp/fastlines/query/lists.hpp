// Lists of hits: each ray has its own number of them, so they wait in chunks until all are counted, and are then put
// into arrays: compressed sparse rows (CSR), those of ray i from offsets[i] to offsets[i + 1].
#pragma once

#include <algorithm>
#include <cstring>

#include "../memory/memory.hpp"
#include "batch.hpp"

namespace fastlines {

/// Where hits go: one array a property; t_out may be missing.
struct HitColumns {
  float *t, *u, *distance, *t_out;
  std::int64_t* prim;

  template <class AnyHit>
  void set(std::size_t i, const AnyHit& hit) const {
    t[i] = hit.t;
    u[i] = hit.u;
    distance[i] = hit.distance;
    prim[i] = hit.prim;
    if (t_out) t_out[i] = hit.t_out;
  }
};

/// A hit on its way to its place.
struct PackedHit {
  float t, u, distance, t_out;
  std::uint32_t prim;

  PackedHit() {}  // not cleared: lists of them grow by many
  PackedHit(float t_, float u_, float distance_, float t_out_, std::uint32_t prim_)
      : t(t_), u(u_), distance(distance_), t_out(t_out_), prim(prim_) {}

  bool operator<(const PackedHit& other) const { return t != other.t ? t < other.t : prim < other.prim; }
};

/// The hits of some rays: each ray's in a run, sorted. Rays without any have none.
struct HitLists {
  struct Run {
    std::uint32_t ray, n_hits;
  };
  std::vector<Run> runs;
  LargeVector<PackedHit> hits;

  void add(std::uint32_t ray, std::vector<Hit>& of_ray) {
    if (of_ray.empty()) return;
    std::sort(of_ray.begin(), of_ray.end());
    runs.push_back({ray, std::uint32_t(of_ray.size())});
    for (const Hit& hit : of_ray) hits.push_back({hit.t, hit.u, hit.distance, hit.t_out, std::uint32_t(hit.prim)});
  }
};

class PendingLists {
 public:
  PendingLists(std::size_t n_rays, std::size_t n_chunks) : offsets_(n_rays + 1), chunks_(n_chunks) {}

  /// Take the lists of a chunk; they are empty afterwards, but keep their memory.
  void take(std::size_t chunk, HitLists& lists) {
    for (const HitLists::Run& run : lists.runs) offsets_[run.ray + 1] = run.n_hits;
    const std::size_t n_bytes = lists.hits.size() * sizeof(PackedHit);
    chunks_[chunk] = {lists.runs, arena_->take(n_bytes)};
    if (n_bytes) std::memcpy(chunks_[chunk].hits.get(), lists.hits.data(), n_bytes);
    lists.runs.clear();
    lists.hits.clear();
  }

  /// All chunks are there.
  void finish() {
    for (std::size_t i = 1; i < offsets_.size(); ++i) offsets_[i] += offsets_[i - 1];
  }

  /// Where the hits of each ray begin, and where the last ones end; after this there is nothing left to place.
  LargeVector<std::int64_t> take_offsets() { return std::move(offsets_); }
  std::size_t n_hits() const { return std::size_t(offsets_.back()); }

  /// Put the hits into columns, and forget them.
  void place(const HitColumns& to, unsigned n_threads) {
    Progress unwatched;
    for_each_chunk(
        chunks_.size(), n_threads, unwatched, [] { return 0; },
        [&](int, std::size_t chunk) {
          const auto* hit = reinterpret_cast<const PackedHit*>(chunks_[chunk].hits.get());
          for (const HitLists::Run& run : chunks_[chunk].runs) {
            auto i = std::size_t(offsets_[run.ray]);
            for (std::uint32_t n = run.n_hits; n > 0; --n) to.set(i++, *hit++);
          }
          chunks_[chunk] = {};
        });
  }

 private:
  struct Chunk {
    std::vector<HitLists::Run> runs;
    std::shared_ptr<std::byte> hits;
  };
  LargeVector<std::int64_t> offsets_;
  std::vector<Chunk> chunks_;
  std::unique_ptr<Arena> arena_ = std::make_unique<Arena>();
};

/// What the sinks that make(ray) gives have listed for each ray.
template <class Search, class Make>
PendingLists list_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress,
                       Make&& make) {
  struct Worker {
    Scratch scratch;
    HitLists lists;
  };
  const std::size_t n_chunks = (rays.size() + kChunk - 1) / kChunk;
  PendingLists pending(rays.size(), n_chunks);
  for_each_chunk(
      n_chunks, n_threads, progress, [] { return Worker{}; },
      [&](Worker& worker, std::size_t chunk) {
        for (std::size_t i = chunk * kChunk; i < std::min(rays.size(), (chunk + 1) * kChunk); ++i) {
          progress.check();
          const Ray ray = prepare(rays[i], search.frame);
          auto sink = make(ray);
          search(ray, sink, worker.scratch);
          worker.lists.add(std::uint32_t(i), sink.hits);
        }
        pending.take(chunk, worker.lists);
      });
  pending.finish();
  return pending;
}

}  // namespace fastlines
