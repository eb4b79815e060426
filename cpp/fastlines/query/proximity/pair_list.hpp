// Collects the pairs that threads find in any order, and sorts them.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>

#include "../../memory/buffer.hpp"
#include "../../parallel/parallel_for.hpp"
#include "pair_query.hpp"

namespace fastlines {

/// Two rows, and their nearest places.
struct FoundPair {
  std::uint32_t i, j;
  float s, t, distance;  ///< in units of the scene
};

/// Pairs as columns, sorted by their primitives.
struct PairColumns {
  Buffer<std::int64_t> i, j;
  Buffer<float> s, t, distance;

  void resize(std::size_t n) {
    for (Buffer<std::int64_t>* column : {&i, &j}) {
      column->reset(n);
      column->set_size(n);
    }
    for (Buffer<float>* column : {&s, &t, &distance}) {
      column->reset(n);
      column->set_size(n);
    }
  }
  void set(std::size_t at, const FoundPair& pair) {
    i[at] = pair.i;
    j[at] = pair.j;
    s[at] = pair.s;
    t[at] = pair.t;
    distance[at] = pair.distance;
  }
};

/// The pairs of a query. Two primitives of several rows make one pair, that of the least distance; equally near rows
/// rank by their numbers. So the list depends neither on the order in which pairs are found nor on repeats.
class PairList {
 public:
  explicit PairList(const PairQuery& query) : query_(query) {}

  /// Where one thread adds the pairs that it finds.
  class Part {
   public:
    explicit Part(PairList& list) : list_(list) {}

    void add(const FoundPair& pair) {
      if (pairs_.size() == pairs_.capacity()) reserve_more(pairs_, 1);
      pairs_.push_back(pair);
    }

    /// Call now and then: keeps the best of the pairs of two primitives of several rows once there are many, and throws
    /// TooManyPairs if all threads together have found more than allowed.
    void check(const Progress& progress) {
      count();
      if (!list_.query_.has_pieces()) return list_.require_room();
      const bool has_many = pairs_.size() >= 2 * n_kept_ + kMany,
                 has_some = pairs_.size() >= n_kept_ + n_kept_ / 4 + kMany;
      if (has_many || (has_some && !list_.has_room())) {
        pairs_.resize(list_.sort_unique(pairs_.data(), pairs_.data() + pairs_.size(), progress));
        n_kept_ = pairs_.size();
        count();
      }
      list_.require_room();
    }

   private:
    friend class PairList;
    static constexpr std::size_t kMany = 256;

    /// Call visit(pair) for all pairs.
    template <class Visit>
    void for_each(const Progress& progress, const Visit& visit) const {
      constexpr std::size_t at_once = 1 << 20;
      for (std::size_t begin = 0; begin < pairs_.size(); begin += at_once) {
        progress.check();
        const std::size_t end = std::min(begin + at_once, pairs_.size());
        for (std::size_t i = begin; i < end; ++i) visit(pairs_[i]);
      }
    }

    /// Tell the list how many pairs there are.
    void count() {
      list_.n_found_.fetch_add(std::int64_t(pairs_.size()) - std::int64_t(std::exchange(n_counted_, pairs_.size())));
    }

    PairList& list_;
    LargeVector<FoundPair> pairs_;
    std::size_t n_counted_ = 0;
    std::size_t n_kept_ = 0;  // after the last time that they were reduced
  };

  /// A part for another thread. It lives as long as the list.
  Part* part() {
    const std::lock_guard lock(mutex_);
    return &parts_.emplace_back(*this);
  }

  /// Sort all pairs. Call once.
  PairColumns sorted(unsigned n_threads, Progress& progress, Stage stage) {
    constexpr std::size_t counted_from = 64;  // primitives for each pair, where counting those of each is worth while
    std::size_t n_pairs = 0;
    for (const Part& part : parts_) n_pairs += part.pairs_.size();
    if (n_pairs * counted_from < query_.first.n_prims()) return sorted_at_once(n_pairs, progress);
    return sorted_by_first(n_threads, progress, stage);
  }

 private:
  PairColumns sorted_at_once(std::size_t n_pairs, const Progress& progress) const {
    std::vector<FoundPair> pairs;
    pairs.reserve(n_pairs);
    for (const Part& part : parts_) pairs.insert(pairs.end(), part.pairs_.begin(), part.pairs_.end());
    PairColumns columns;
    columns.resize(sort_unique(pairs.data(), pairs.data() + pairs.size(), progress));
    for (std::size_t at = 0; at < columns.i.size(); ++at) columns.set(at, pairs[at]);
    return columns;
  }

  PairColumns sorted_by_first(unsigned n_threads, Progress& progress, Stage stage) {
    constexpr std::size_t chunk_size = 4096;  // primitives
    const std::size_t n_prims = query_.first.n_prims();
    // Move the pairs of each first primitive together.
    LargeVector<std::size_t> begins(n_prims + 2);
    for (const Part& part : parts_)
      part.for_each(progress, [&](const FoundPair& pair) { ++begins[prim_of(pair) + 2]; });
    for (std::size_t prim = 2; prim < n_prims + 2; ++prim) begins[prim] += begins[prim - 1];
    Buffer<FoundPair> pairs;
    pairs.reset(begins[n_prims + 1]);
    for (Part& part : parts_) {
      part.for_each(progress, [&](const FoundPair& pair) { pairs[begins[prim_of(pair) + 1]++] = pair; });
      part.pairs_ = {};
    }
    // Now the pairs of a primitive are those from begins[prim] up to begins[prim + 1].
    const double half = 0.5 * (stage.from + stage.to);
    LargeVector<std::size_t> to(n_prims + 1);
    const auto for_each_chunk = [&](Stage of, const auto& work) {
      parallel_for_chunks(
          n_prims, chunk_size, n_threads, progress, [] { return 0; },
          [&](int, std::size_t begin, std::size_t end) {
            for (std::size_t prim = begin; prim < end; ++prim) work(prim);
          },
          of);
    };
    for_each_chunk({stage.from, half}, [&](std::size_t prim) {
      to[prim + 1] = sort_unique(pairs.data() + begins[prim], pairs.data() + begins[prim + 1], progress);
    });
    for (std::size_t prim = 0; prim < n_prims; ++prim) to[prim + 1] += to[prim];
    PairColumns columns;
    columns.resize(to[n_prims]);
    for_each_chunk({half, stage.to}, [&](std::size_t prim) {
      const FoundPair* from = pairs.data() + begins[prim];
      for (std::size_t at = to[prim]; at < to[prim + 1]; ++at, ++from) columns.set(at, *from);
    });
    return columns;
  }

  bool has_room() const { return std::size_t(std::max<std::int64_t>(n_found_.load(), 0)) <= query_.max_pairs; }
  void require_room() const {
    if (!has_room()) throw TooManyPairs{};
  }

  std::size_t prim_of(const FoundPair& pair) const { return std::size_t(query_.first.owner_of(pair.i)); }

  /// Sort pairs, and keep the best of each two primitives. Returns their number.
  std::size_t sort_unique(FoundPair* begin, FoundPair* end, const Progress& progress) const {
    const auto prims = [this](const FoundPair& pair) {
      return std::pair(query_.first.owner_of(pair.i), query_.second.owner_of(pair.j));
    };
    std::uint32_t n_compared = 0;
    std::sort(begin, end, [&](const FoundPair& a, const FoundPair& b) {
      if ((++n_compared & 0xfffff) == 0) progress.check();
      const auto prims_a = prims(a), prims_b = prims(b);
      if (prims_a != prims_b) return prims_a < prims_b;
      if (a.distance != b.distance) return a.distance < b.distance;
      return a.i != b.i ? a.i < b.i : a.j < b.j;
    });
    const auto same = [&](const FoundPair& a, const FoundPair& b) { return prims(a) == prims(b); };
    return std::size_t(std::unique(begin, end, same) - begin);
  }

  const PairQuery& query_;
  std::mutex mutex_;
  std::deque<Part> parts_;
  std::atomic<std::int64_t> n_found_{0};
};

}  // namespace fastlines
