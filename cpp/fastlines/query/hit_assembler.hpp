// Assembles the lists of all rays into flat arrays as compressed sparse rows (CSR): the hits of ray i are those from
// offsets[i] up to offsets[i + 1]. A ray's offset is known once the hits of all rays before it are counted.
#pragma once

#include <exception>
#include <map>
#include <mutex>
#include <shared_mutex>

#include "../memory/buffer.hpp"
#include "../parallel/progress.hpp"
#include "hit_buffer.hpp"

namespace fastlines {

/// Thrown by `HitAssembler::add` if there are more hits than may be in memory.
struct TooManyHits : std::exception {
  const char* what() const noexcept override { return "more hits than may be in memory"; }
};

/// Copies hits to their final places while other rays are still being traced. A quarter of all chunks, spread over all
/// rays, is traced first, to estimate the total number of hits. From then on, the hits of a chunk stay buffered only
/// until all rays before its last one are counted. So buffers stay small, and their memory is soon reused.
class HitAssembler {
 public:
  HitAssembler(std::size_t n_rays, bool with_t_out, std::size_t max_hits = ~std::size_t(0))
      : with_t_out_(with_t_out), max_hits_(max_hits), offsets_(n_rays + 1) {}

  /// The i-th chunk to trace: every fourth one, then the others.
  static std::size_t sample_first(std::size_t i, std::size_t n_chunks) {
    const std::size_t n_sampled = (n_chunks + 3) / 4, other = i - n_sampled;
    return i < n_sampled ? 4 * i : other + other / 3 + 1;
  }

  /// Add the lists of a chunk, and clear them. This chunk and those before it contain all rays before `until`. Threads
  /// may call it at the same time.
  void add(std::size_t chunk, std::size_t n_chunks, std::size_t until, HitBuffer& lists) {
    std::size_t end = 0, n_hits = 0;
    for (const HitBuffer::RayRun& run : lists.runs) {
      offsets_[run.ray + 1] = run.n_hits;
      n_hits += run.n_hits;
      end = std::max<std::size_t>(end, run.ray + 1);
    }
    Chunk added{until, end, lists.runs, std::exchange(lists.blocks, {})};
    std::vector<Chunk> ready;
    {
      const std::lock_guard lock(mutex_);
      waiting_.emplace(chunk, std::move(added));
      n_hits_added_ += n_hits;
      if (n_hits_added_ > max_hits_) throw TooManyHits{};
      if (const std::size_t n_added = ++n_added_; 4 * n_added >= n_chunks) {
        count();
        while (!waiting_.empty() && waiting_.begin()->first < next_ && waiting_.begin()->second.end <= n_counted_)
          ready.push_back(std::move(waiting_.extract(waiting_.begin()).mapped()));
        reserve(std::size_t(offsets_[n_counted_]), double(n_hits_added_) / double(n_added) * double(n_chunks));
      }
    }
    lists.clear();
    const std::shared_lock lock(columns_mutex_);
    for (const Chunk& counted : ready) copy(counted);
  }

  bool with_t_out() const { return with_t_out_; }

  /// Where the hits of each ray begin, and where the last ones end. Call once, after all chunks are added.
  LargeVector<std::int64_t> offsets() { return std::move(offsets_); }

  Buffer<float> t, u, distance, t_out;  ///< t_out is empty unless requested
  Buffer<std::int64_t> prim;
  const Progress* progress = nullptr;  ///< checked while hits are copied, if there is one

 private:
  static constexpr std::size_t kCopiedAtOnce = 1 << 20;  // hits

  /// The lists of a chunk; all its rays with hits come before `end`.
  struct Chunk {
    std::size_t until, end;
    std::vector<HitBuffer::RayRun> runs;
    std::vector<HitBuffer::Block> blocks;
  };

  /// Turn counts into offsets, as far as all rays are counted.
  void count() {
    std::size_t n = n_counted_;
    for (auto chunk = waiting_.find(next_); chunk != waiting_.end() && chunk->first == next_; ++chunk, ++next_)
      n = chunk->second.until;
    std::int64_t n_hits = offsets_[n_counted_];
    for (; n_counted_ < n; ++n_counted_) offsets_[n_counted_ + 1] = n_hits += offsets_[n_counted_ + 1];
  }

  /// Reserve n_hits, and 1.5 times the expected total if the system grants it. Unused capacity costs only addresses.
  void reserve(std::size_t n_hits, double n_expected) {
    if (n_hits <= capacity_) return;
    const std::lock_guard lock(columns_mutex_);
    const std::size_t enough = n_hits + (capacity_ > 0 ? n_hits / 2 : 0);
    try {
      grow(std::max(enough, std::size_t(1.5 * n_expected)));
    } catch (const std::bad_alloc&) {
      grow(enough);
    }
  }

  void grow(std::size_t capacity) {
    for (Buffer<float>* column : {&t, &u, &distance}) column->grow(capacity, capacity_);
    if (with_t_out_) t_out.grow(capacity, capacity_);
    prim.grow(capacity, capacity_);
    capacity_ = capacity;
  }

  /// Copy the hits of a chunk to their places. Runs of rays that are neighbours in the batch are copied together.
  void copy(const Chunk& chunk) {
    const HitColumns to{t.data(), prim.data(), u.data(), distance.data(), with_t_out_ ? t_out.data() : nullptr};
    const HitBuffer::RayRun* run = chunk.runs.data();
    for (const HitBuffer::Block& block : chunk.blocks) {
      const HitBuffer::RayRun* const last = run + block.n_runs;
      const ListColumns columns = block.columns();
      std::size_t begin = 0, end = 0;  // in the block: hits that stay contiguous
      while (run != last) {
        const auto at = std::size_t(offsets_[run->ray]);
        for (; run != last && std::size_t(offsets_[run->ray]) - at == end - begin; ++run) end += run->n_hits;
        const std::size_t first = begin;
        for (std::size_t n = 0; begin < end; begin += n) {
          n = std::min(end - begin, kCopiedAtOnce);
          copy(columns.from(begin), to.from(at + (begin - first)), n);
          if (progress) progress->check();
        }
      }
    }
  }

  static void copy(const ListColumns& from, const HitColumns& to, std::size_t n) {
    const auto copy_batch = [&](std::size_t i, auto n_batch) {
      std::memcpy(to.t + i, from.t + i, n_batch * sizeof(float));
      std::memcpy(to.u + i, from.u + i, n_batch * sizeof(float));
      std::memcpy(to.distance + i, from.distance + i, n_batch * sizeof(float));
      std::copy_n(from.prim + i, n_batch, to.prim + i);
    };
    // Let the last batch overlap the one before it, so that no loop over single hits is needed.
    const auto copy_all = [&](auto batch) {
      for (std::size_t i = 0; i + batch < n; i += batch) copy_batch(i, batch);
      copy_batch(n - batch, batch);
    };
    if (n >= 16)
      copy_all(std::integral_constant<std::size_t, 16>());
    else if (n >= 4)
      copy_all(std::integral_constant<std::size_t, 4>());
    else
      for (std::size_t i = 0; i < n; ++i) copy_batch(i, std::integral_constant<std::size_t, 1>());
    if (to.t_out) std::copy_n(from.t_out, n, to.t_out);
  }

  const bool with_t_out_;
  const std::size_t max_hits_;
  LargeVector<std::int64_t> offsets_;  // beyond `n_counted_`: how many hits the previous ray has
  std::mutex mutex_;                   // guards what follows
  std::size_t n_added_ = 0, n_hits_added_ = 0;
  std::size_t next_ = 0, n_counted_ = 0;  // the first chunk not added, the first ray not counted
  std::size_t capacity_ = 0;              // of each column, in hits
  std::map<std::size_t, Chunk> waiting_;
  std::shared_mutex columns_mutex_;  // shared: writes to the columns; exclusive: moves them
};

}  // namespace fastlines
