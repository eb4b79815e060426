// Tests every pair of primitives: the reference for the pairs of all trees. With N = FloatX16, 16 at a time.
#pragma once

#include "../../primitives/pair_test.hpp"
#include "pair_list.hpp"

namespace fastlines {

/// Tests all pairs of a query, and adds those within the radius.
template <bool surface, class N>
class AllPairs {
 public:
  explicit AllPairs(const PairQuery& query)
      : query_(query),
        radius_(query.frame_radius()),
        radius2_(radius_ * radius_),
        to_scene_(1.0f / query.frame.scale) {}

  void test(PairList& list, unsigned n_threads, Progress& progress, Stage stage) const {
    struct Worker {
      PairList::Part* part;
      Checkpoint checkpoint;
    };
    constexpr std::size_t chunk_size = 16;  // rows
    parallel_for_chunks(
        query_.first.n_rows, chunk_size, n_threads, progress, [&] { return Worker{list.part(), Checkpoint(progress)}; },
        [&](Worker& worker, std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            test_row(std::uint32_t(i), worker.part, worker.checkpoint);
            worker.part->check(progress);
          }
        },
        stage);
  }

 private:
  static constexpr std::uint32_t kLanes = sizeof(N) / sizeof(float);

  /// Test a row of the first set with all of the second set, or with those after it.
  void test_row(std::uint32_t i, PairList::Part* to, Checkpoint& checkpoint) const {
    float one[kAxisFields];
    query_.first.load<surface>(i, query_.frame, one);
    N first[kAxisFields], second[kAxisFields];
    std::copy_n(one, kAxisFields, first);
    const auto n_rows = std::uint32_t(query_.second.n_rows);
    for (std::uint32_t j = query_.is_self ? i + 1 : 0; j < n_rows; j += kLanes) {
      checkpoint.pass();
      load(j, second);
      const NearestPair<N> found = nearest_pair<surface>(first, second, N(radius_), N(radius2_));
      add(i, j, std::min(kLanes, n_rows - j), found, to);
    }
  }

  void load(std::uint32_t j, N (&fields)[kAxisFields]) const {
    const AxisSet& set = query_.second;
    if constexpr (kLanes == 1) {
      set.load<surface>(j, query_.frame, fields);
    } else {
      const float* rows[kLanes];
      for (std::uint32_t lane = 0; lane < kLanes; ++lane)
        rows[lane] = set.row(std::min(j + lane, std::uint32_t(set.n_rows - 1)));
      set.load<surface>(rows, query_.frame, fields);
    }
  }

  void add(std::uint32_t i, std::uint32_t j, std::uint32_t, const NearestPair<float>& found, PairList::Part* to) const {
    if (found.within && query_.counts(i, j)) to->add({i, j, found.s, found.t, found.distance * to_scene_});
  }

  /// Add those of the first n of 16 pairs with consecutive rows of the second set that count.
  void add(std::uint32_t i, std::uint32_t j, std::uint32_t n, const NearestPair<FloatX16>& found,
           PairList::Part* to) const {
    std::uint32_t bits = found.within.bits() & lane_mask(n);
    if (bits == 0) return;
    float s[kSimdWidth], t[kSimdWidth], distance[kSimdWidth];
    found.s.store(s);
    found.t.store(t);
    found.distance.store(distance);
    for (; bits; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      add(i, j + std::uint32_t(lane), 1, NearestPair<float>{s[lane], t[lane], distance[lane], true}, to);
    }
  }

  const PairQuery& query_;
  float radius_, radius2_, to_scene_;
};

/// The pairs of a query by brute force, sorted.
template <class N>
PairColumns all_pairs(const PairQuery& query, unsigned n_threads, Progress& progress) {
  PairList list(query);
  const Stage stage{0.0, 0.9};
  if (query.surface)
    AllPairs<true, N>{query}.test(list, n_threads, progress, stage);
  else
    AllPairs<false, N>{query}.test(list, n_threads, progress, stage);
  return list.sorted(n_threads, progress, {0.9, 1.0});
}

}  // namespace fastlines
