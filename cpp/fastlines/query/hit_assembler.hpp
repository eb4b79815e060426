// Lists of hits: each ray has its own number of them, so they wait until the rays before are counted, and are then put
// into arrays: compressed sparse rows (CSR), those of ray i from offsets[i] to offsets[i + 1].
#pragma once

#include <map>
#include <mutex>
#include <shared_mutex>

#include "../memory/buffer.hpp"
#include "hit_buffer.hpp"

namespace fastlines {

/// The hits of all rays in their places, where they are put while other rays are still under way. A fourth of all
/// chunks, spread over all rays, comes first and tells how much room there has to be. From then on a chunk's hits wait,
/// as their thread has listed them, only until all rays before its last one are counted. So what waits is little, and
/// its memory soon serves again.
class HitAssembler {
 public:
  HitAssembler(std::size_t n_rays, bool with_t_out) : with_t_out_(with_t_out), offsets_(n_rays + 1) {}

  /// Which chunk is to come i-th: every fourth, then the others.
  static std::size_t sample_first(std::size_t i, std::size_t n_chunks) {
    const std::size_t n_sampled = (n_chunks + 3) / 4, other = i - n_sampled;
    return i < n_sampled ? 4 * i : other + other / 3 + 1;
  }

  /// Take the lists of a chunk; they are empty afterwards. With this chunk and those before it all rays before `until`
  /// are counted.
  void add(std::size_t chunk, std::size_t n_chunks, std::size_t until, HitBuffer& lists) {
    std::size_t end = 0, n_hits = 0;
    for (const HitBuffer::RayRun& run : lists.runs) {
      offsets_[run.ray + 1] = run.n_hits;
      n_hits += run.n_hits;
      end = std::max<std::size_t>(end, run.ray + 1);
    }
    Chunk taken{until, end, lists.runs, std::exchange(lists.blocks, {})};
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
    std::vector<HitBuffer::RayRun> runs;
    std::vector<HitBuffer::Block> blocks;
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
    const HitColumns to{t.data(), prim.data(), u.data(), distance.data(), with_t_out_ ? t_out.data() : nullptr};
    const HitBuffer::RayRun* run = chunk.runs.data();
    for (const HitBuffer::Block& block : chunk.blocks) {
      const HitBuffer::RayRun* const last = run + block.n_runs;
      const ListColumns columns = block.columns();
      std::size_t begin = 0, end = 0;  // in the block: hits that go side by side
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

}  // namespace fastlines
