// Lists of hits: each ray has its own number of them, so they wait until the rays before are counted, and are then put
// into arrays: compressed sparse rows (CSR), those of ray i from offsets[i] to offsets[i + 1].
#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <shared_mutex>

#include "../memory/buffer.hpp"
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

/// The hits of all rays in their places, where they are put while other rays are still under way. A fourth of all
/// chunks, spread over all rays, comes first and tells how much room there has to be. From then on a chunk's hits wait,
/// as their thread has listed them, only until all rays before its last one are counted. So what waits is little, and
/// its memory soon serves again.
class PlacedLists {
 public:
  PlacedLists(std::size_t n_rays, bool with_t_out) : with_t_out_(with_t_out), offsets_(n_rays + 1) {}

  /// Which chunk is to come i-th: every fourth, then the others.
  static std::size_t spread_first(std::size_t i, std::size_t n_chunks) {
    const std::size_t n_spread = (n_chunks + 3) / 4, other = i - n_spread;
    return i < n_spread ? 4 * i : other + other / 3 + 1;
  }

  /// Take the lists of a chunk; they are empty afterwards. With this chunk and those before it all rays before `until`
  /// are counted.
  void take(std::size_t chunk, std::size_t n_chunks, std::size_t until, HitLists& lists) {
    std::size_t end = 0, n_hits = 0;
    for (const HitLists::Run& run : lists.runs) {
      offsets_[run.ray + 1] = run.n_hits;
      n_hits += run.n_hits;
      end = std::max<std::size_t>(end, run.ray + 1);
    }
    Chunk taken{until, end, lists.runs, std::exchange(lists.pieces, {})};
    std::vector<Chunk> known;
    {
      const std::lock_guard lock(mutex_);
      waiting_.emplace(chunk, std::move(taken));
      n_hits_taken_ += n_hits;
      if (const std::size_t n_taken = ++n_taken_; 4 * n_taken >= n_chunks) {
        count();
        while (!waiting_.empty() && waiting_.begin()->first < next_ && waiting_.begin()->second.end <= n_counted_)
          known.push_back(std::move(waiting_.extract(waiting_.begin()).mapped()));
        make_room(std::size_t(offsets_[n_counted_]), double(n_hits_taken_) / double(n_taken) * double(n_chunks));
      }
    }
    lists.clear();
    const std::shared_lock lock(place_);
    for (const Chunk& of : known) place(of);
  }

  bool with_t_out() const { return with_t_out_; }

  /// All chunks have been taken: where the hits of each ray begin, and where the last ones end.
  LargeVector<std::int64_t> offsets() { return std::move(offsets_); }

  Buffer<float> t, u, distance, t_out;  // t_out is empty unless it was asked for
  Buffer<std::int64_t> prim;

 private:
  struct Chunk {
    std::size_t until, end;  // all its rays come before `end`
    std::vector<HitLists::Run> runs;
    std::vector<HitLists::Piece> pieces;
  };

  /// Turn counts into offsets as far as all rays have been counted.
  void count() {
    std::size_t n = n_counted_;
    for (auto chunk = waiting_.find(next_); chunk != waiting_.end() && chunk->first == next_; ++chunk, ++next_)
      n = chunk->second.until;
    std::int64_t n_hits = offsets_[n_counted_];
    for (; n_counted_ < n; ++n_counted_) offsets_[n_counted_ + 1] = n_hits += offsets_[n_counted_ + 1];
  }

  /// Have room for so many hits, and for those to be expected in all if the system gives as much. Room that is not used
  /// costs only addresses.
  void make_room(std::size_t n_hits, double n_expected) {
    if (n_hits <= room_) return;
    const std::lock_guard lock(place_);
    const std::size_t enough = n_hits + (room_ > 0 ? n_hits / 2 : 0);
    try {
      grow(std::max(enough, std::size_t(1.5 * n_expected)));
    } catch (const std::bad_alloc&) {
      grow(enough);
    }
  }

  void grow(std::size_t room) {
    for (Buffer<float>* column : {&t, &u, &distance}) column->grow(room, room_);
    if (with_t_out_) t_out.grow(room, room_);
    prim.grow(room, room_);
    room_ = room;
  }

  /// The runs of rays that follow each other in the batch are placed together.
  void place(const Chunk& chunk) {
    const HitColumns to{t.data(), u.data(), distance.data(), with_t_out_ ? t_out.data() : nullptr, prim.data()};
    const HitLists::Run* run = chunk.runs.data();
    for (const HitLists::Piece& piece : chunk.pieces) {
      const HitLists::Run* const last = run + piece.n_runs;
      const ListColumns columns = piece.columns();
      std::size_t begin = 0, end = 0;  // in the piece: hits that go side by side
      while (run != last) {
        const auto at = std::size_t(offsets_[run->ray]);
        for (; run != last && std::size_t(offsets_[run->ray]) - at == end - begin; ++run) end += run->n_hits;
        copy(columns.from(begin), to.from(at), end - begin);
        begin = end;
      }
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

  const bool with_t_out_;
  LargeVector<std::int64_t> offsets_;  // beyond `n_counted_`: how many hits the ray before has
  std::mutex mutex_;                   // of what follows
  std::size_t n_taken_ = 0, n_hits_taken_ = 0;
  std::size_t next_ = 0, n_counted_ = 0;  // the first chunk that has not been taken, the first ray not counted
  std::size_t room_ = 0;
  std::map<std::size_t, Chunk> waiting_;
  std::shared_mutex place_;  // of the columns: many may write to them, or one may move them
};

/// What the sinks that make(ray) gives have listed for each ray.
template <class Search, class Make>
void list_hits(const Search& search, const RayBatch& rays, unsigned n_threads, Progress& progress, PlacedLists& to,
               Make&& make) {
  struct Worker {
    typename Search::Scratch scratch;
    HitLists lists;
  };
  const std::size_t n_chunks = (rays.size() + kChunk - 1) / kChunk;
  for_each_chunk(
      n_chunks, n_threads, progress, [] { return Worker{}; },
      [&](Worker& worker, std::size_t i_chunk) {
        const std::size_t chunk = PlacedLists::spread_first(i_chunk, n_chunks);
        const std::size_t end = std::min(rays.size(), (chunk + 1) * kChunk);
        for (std::size_t i = chunk * kChunk; i < end; ++i) {
          progress.check();
          const Ray ray = prepare(rays[i], search.frame);
          auto sink = make(ray);
          search(ray, sink, worker.scratch);
          worker.lists.add(std::uint32_t(i), sink.hits);
        }
        to.take(chunk, n_chunks, end, worker.lists);
      });
}

}  // namespace fastlines
