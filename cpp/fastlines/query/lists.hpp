// Lists of hits: each ray has its own number of them, so they wait in chunks until all are counted, and are then put
// into arrays: compressed sparse rows (CSR), those of ray i from offsets[i] to offsets[i + 1].
#pragma once

#include <algorithm>
#include <cstring>

#include "../memory/memory.hpp"
#include "batch.hpp"

namespace fastlines {

/// Hits as arrays, one a property; t_out may be missing.
template <class Prim>
struct ColumnsOf {
  float *t, *u, *distance, *t_out;
  Prim* prim;

  void set(std::size_t i, const Hit& hit) const {
    t[i] = hit.t;
    u[i] = hit.u;
    distance[i] = hit.distance;
    prim[i] = Prim(hit.prim);
    if (t_out) t_out[i] = hit.t_out;
  }

  /// The same from hit i on.
  ColumnsOf from(std::size_t i) const { return {t + i, u + i, distance + i, t_out ? t_out + i : nullptr, prim + i}; }

  /// Move hit i, but for t_out, to where hit j stands, and those from there on one further.
  void move(std::size_t i, std::size_t j) const {
    std::rotate(t + j, t + i, t + i + 1);
    std::rotate(u + j, u + i, u + i + 1);
    std::rotate(distance + j, distance + i, distance + i + 1);
    std::rotate(prim + j, prim + i, prim + i + 1);
  }

  /// Whether hit i comes before hit j, both of one ray.
  bool before(std::size_t i, std::size_t j) const { return (t[i] < t[j]) | ((t[i] == t[j]) & (prim[i] < prim[j])); }
};
using HitColumns = ColumnsOf<std::int64_t>;
using ListColumns = ColumnsOf<std::uint32_t>;

/// The hits of some rays on their way to their places, each ray's in a run, sorted.
struct HitLists {
  struct Run {
    std::uint32_t ray, n_hits;
  };
  /// Some runs, whose hits stand one column after the other: u, prim, t, distance, and t_out, which may be missing.
  struct Piece {
    std::uint32_t n_hits, n_runs;
    std::shared_ptr<std::byte> data;

    ListColumns columns() const {
      auto* const first = reinterpret_cast<float*>(data.get());
      const std::size_t n = n_hits;
      return {first + 2 * n, first, first + 3 * n, first + 4 * n, reinterpret_cast<std::uint32_t*>(first + n)};
    }
  };
  std::vector<Run> runs;
  std::vector<Piece> pieces;
  Arena arena;

  /// Begin a piece: where so many hits are to be written. A column may be written past its end, by up to sixteen,
  /// as long as the next one is not.
  ListColumns begin(std::uint32_t n_hits) {
    pieces.push_back({n_hits, 0, arena.begin((5 * std::size_t(n_hits) + kWidth) * sizeof(float))});
    return pieces.back().columns();
  }

  /// The next hits of the piece are this ray's.
  void add(std::uint32_t ray, std::uint32_t n_hits) {
    runs.push_back({ray, n_hits});
    ++pieces.back().n_runs;
  }

  /// All hits of the piece stand in their places: this many columns of them.
  void end(std::uint32_t n_columns) { arena.end(n_columns * std::size_t(pieces.back().n_hits) * sizeof(float)); }

  /// A piece for one ray.
  void add(std::uint32_t ray, std::vector<Hit>& of_ray) {
    if (of_ray.empty()) return;
    std::sort(of_ray.begin(), of_ray.end());
    const ListColumns to = begin(std::uint32_t(of_ray.size()));
    for (std::size_t i = 0; i < of_ray.size(); ++i) to.set(i, of_ray[i]);
    add(ray, std::uint32_t(of_ray.size()));
    end(5);
  }

  void clear() {
    runs.clear();
    pieces.clear();
  }
};

class PendingLists {
 public:
  PendingLists(std::size_t n_rays, std::size_t n_chunks) : offsets_(n_rays + 1), chunks_(n_chunks) {}

  /// Take the lists of a chunk; they are empty afterwards.
  void take(std::size_t chunk, HitLists& lists) {
    for (const HitLists::Run& run : lists.runs) offsets_[run.ray + 1] = run.n_hits;
    std::vector<HitLists::Piece> pieces(lists.pieces.size());
    std::move(lists.pieces.begin(), lists.pieces.end(), pieces.begin());
    chunks_[chunk] = {lists.runs, std::move(pieces)};
    lists.clear();
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
          const HitLists::Run* run = chunks_[chunk].runs.data();
          for (const HitLists::Piece& piece : chunks_[chunk].pieces) {
            place(piece.columns(), run, run + piece.n_runs, to);
            run += piece.n_runs;
          }
          chunks_[chunk] = {};
        });
  }

 private:
  struct Chunk {
    std::vector<HitLists::Run> runs;
    std::vector<HitLists::Piece> pieces;
  };

  /// The runs of rays that follow each other in the batch are placed together.
  void place(const ListColumns& piece, const HitLists::Run* run, const HitLists::Run* last,
             const HitColumns& to) const {
    std::size_t begin = 0, end = 0;  // in the piece: hits that go side by side
    while (run != last) {
      const auto at = std::size_t(offsets_[run->ray]);
      for (; run != last && std::size_t(offsets_[run->ray]) - at == end - begin; ++run) end += run->n_hits;
      copy(piece.from(begin), to.from(at), end - begin);
      begin = end;
    }
  }

  static void copy(const ListColumns& from, const HitColumns& to, std::size_t n) {
    const auto some = [&](std::size_t i, auto n_some) {
      std::memcpy(to.t + i, from.t + i, n_some * sizeof(float));
      std::memcpy(to.u + i, from.u + i, n_some * sizeof(float));
      std::memcpy(to.distance + i, from.distance + i, n_some * sizeof(float));
      std::copy_n(from.prim + i, n_some, to.prim + i);
    };
    // The last ones are copied with some that have been, so that there is no loop over single hits.
    const auto all = [&](auto at_once) {
      for (std::size_t i = 0; i + at_once < n; i += at_once) some(i, at_once);
      some(n - at_once, at_once);
    };
    if (n >= 16)
      all(std::integral_constant<std::size_t, 16>());
    else if (n >= 4)
      all(std::integral_constant<std::size_t, 4>());
    else
      for (std::size_t i = 0; i < n; ++i) some(i, std::integral_constant<std::size_t, 1>());
    if (to.t_out) std::copy_n(from.t_out, n, to.t_out);
  }

  LargeVector<std::int64_t> offsets_;
  std::vector<Chunk> chunks_;
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
