// Answers a query for a whole batch of points, in parallel, by any search: brute force, or a traversal of a layout.
// Each point has its own answer, so answers depend neither on the order of points nor on the number of threads.
#pragma once

#include <memory>

#include "../../memory/buffer.hpp"
#include "../../parallel/parallel_for.hpp"
#include "point_collectors.hpp"
#include "point_order.hpp"

namespace fastlines {

/// The answers of a query for the k nearest, as arrays of k entries for each point: infinity, −1 and 0 where there are
/// fewer.
struct NearestColumns {
  float* distance;
  std::int64_t* row;
  float* s;

  /// Write an entry. Distances in the frame are multiplied by `unit`.
  void set(std::size_t i, const Neighbour& found, double unit) const {
    const bool is_hit = found.row != kNoPrim;
    distance[i] = is_hit ? float(double(found.distance) * unit) : kInfinity;
    row[i] = is_hit ? std::int64_t(found.row) : -1;
    s[i] = found.s;
  }
};

/// The primitives within the radius of each point: those of point i are entries offsets[i] up to offsets[i + 1].
struct PointLists {
  LargeVector<std::int64_t> offsets;
  Buffer<float> distance, s;
  Buffer<std::int64_t> row;
};

/// A search of a layout that takes groups of points has a class `Group` for that; other searches have none.
template <class Search>
struct GroupOfSearch {
  struct type {};
};
template <class Search>
  requires requires { typename Search::Group; }
struct GroupOfSearch<Search> {
  using type = typename Search::Group;
};
template <class Search>
using GroupOf = typename GroupOfSearch<Search>::type;

/// A query of points: the search, the points, and what they see.
template <class Search>
struct PointsQuery {
  const Search& search;
  const PointBatch& points;
  const Seen& seen;
  unsigned n_threads;
  Progress& progress;

  /// Find the k nearest primitives of each point.
  void find_nearest(std::size_t k, const NearestColumns& to) const;

  /// Count the primitives within the radius of each point.
  void count(std::int64_t* to) const;

  /// List the primitives within the radius of each point.
  PointLists list() const;

 private:
  /// Points that are sorted and answered together. Few are answered at a time where they have lists.
  static constexpr std::size_t kMostPoints = 1 << 20, kMostListed = 1 << 16, kFewestPoints = 256;
  /// How many points a search for groups takes at a time.
  static constexpr std::size_t kGroup = 16;
  static constexpr bool kHasGroups = requires { typename Search::Group; };
  /// How many points ahead one is prefetched, and how many are answered between two reports of progress.
  static constexpr std::size_t kAhead = 8, kPerReport = 1024;

  struct PerThread {
    explicit PerThread(Progress& progress) : checkpoint(progress) {}
    Checkpoint checkpoint;
    typename Search::Scratch scratch;
    PointOrder sorter;
    const std::vector<std::uint32_t>* sorted = nullptr;
    const std::vector<std::uint32_t>& order() const { return *sorted; }
  };

  struct Block {
    const PointsQuery& query;
    std::size_t index, begin, end;

    /// Call answer(i, point) for the points of the block.
    template <class Worker, class Answer>
    void for_each(Worker& worker, const Answer& answer) const {
      worker.sorted = &worker.sorter.sorted(query.points.coordinates.data() + 3 * begin, end - begin);
      const std::vector<std::uint32_t>& order = worker.order();
      for (std::size_t j = 0; j < order.size(); ++j) {
        const std::size_t i = begin + order[j];
        __builtin_prefetch(query.points.coordinates.data() +
                           3 * (begin + order[std::min(j + kAhead, order.size() - 1)]));
        worker.checkpoint.pass();
        answer(i, query.points.prepare(i, query.search.frame));
        if ((j + 1) % kPerReport == 0) query.progress.add(double(kPerReport) / double(query.points.size()));
      }
    }

    /// Call answer(ids, points) for groups of points.
    template <class Worker, class Answer>
    void for_each_group(Worker& worker, const Answer& answer) const {
      std::size_t ids[kGroup];
      PointQuery group[kGroup];
      std::size_t n = 0;
      const auto flush = [&] {
        if (n > 0) answer(ids, std::span<const PointQuery>(group, n));
        n = 0;
      };
      for_each(worker, [&](std::size_t i, const PointQuery& point) {
        ids[n] = i;
        group[n++] = point;
        if (n == kGroup) flush();
      });
      flush();
    }
  };

  /// Searches for groups of points, if the search can.
  struct GroupWorker : PerThread {
    explicit GroupWorker(const PointsQuery& query) : PerThread(query.progress), group(query.make_group()) {}
    GroupOf<Search> group;
  };

  /// The lists of a block, in the order in which its points are answered.
  struct ListWorker : GroupWorker {
    using GroupWorker::GroupWorker;
    std::vector<Neighbour> found;
  };

  GroupOf<Search> make_group() const {
    if constexpr (kHasGroups)
      return search.group();
    else
      return {};
  }

  double unit() const { return 1.0 / double(search.frame.scale); }

  std::size_t points_per_block(std::size_t most) const {
    return std::clamp(points.size() / (n_threads > 1 ? 4 * n_threads : 1), kFewestPoints, most);
  }
  std::size_t n_blocks(std::size_t most) const {
    const std::size_t per_block = points_per_block(most);
    return (points.size() + per_block - 1) / per_block;
  }

  template <class Worker, class Answer>
  void for_each_block(std::size_t most, const Answer& answer) const {
    const std::size_t per_block = points_per_block(most);
    parallel_for(
        n_blocks(most), n_threads, progress, [&] { return std::make_unique<Worker>(*this); },
        [&](const std::unique_ptr<Worker>& worker, std::size_t i) {
          answer(*worker, Block{*this, i, i * per_block, std::min(points.size(), (i + 1) * per_block)});
        });
  }

  /// List what is near each point. take(worker, i, length) is called for each, which may drop all lists; then
  /// use(worker, block) for each block.
  template <class Take, class Use>
  void for_each_list(const Take& take, const Use& use) const {
    for_each_block<ListWorker>(kMostListed, [&](ListWorker& worker, const Block& block) {
      worker.found.clear();
      if constexpr (kHasGroups)
        block.for_each_group(worker, [&](const std::size_t* ids, std::span<const PointQuery> group) {
          std::uint32_t lengths[kGroup];
          worker.group.list(group, ids, seen, worker.checkpoint, worker.found, lengths);
          for (std::size_t j = 0; j < group.size(); ++j) take(worker, ids[j], lengths[j]);
        });
      else
        block.for_each(worker, [&](std::size_t i, const PointQuery& query) {
          WithinOfPoint within(query, i, seen, Search::kRepeats, worker.found);
          search(query, within, worker.scratch, worker.checkpoint);
          within.finish();
          take(worker, i, within.size());
        });
      use(worker, block);
    });
  }
};

// Outside of the class, these are no inline functions, and `extern template` saves their compilation.

template <class Search>
void PointsQuery<Search>::find_nearest(std::size_t k, const NearestColumns& to) const {
  struct Worker : PerThread {
    explicit Worker(const PointsQuery& query) : PerThread(query.progress) {}
    std::vector<Neighbour> nearest;
  };
  for_each_block<Worker>(kMostPoints, [&](Worker& worker, const Block& block) {
    worker.nearest.resize(k);
    block.for_each(worker, [&](std::size_t i, const PointQuery& query) {
      if (k == 1) {
        NearestOfPoint nearest(query, i, seen);
        search(query, nearest, worker.scratch, worker.checkpoint);
        return to.set(i, nearest.best, unit());
      }
      KNearestOfPoint nearest(query, i, seen, worker.nearest);
      search(query, nearest, worker.scratch, worker.checkpoint);
      const std::size_t n = nearest.found().size();
      for (std::size_t j = 0; j < k; ++j) to.set(i * k + j, j < n ? worker.nearest[j] : Neighbour{}, unit());
    });
  });
}

template <class Search>
void PointsQuery<Search>::count(std::int64_t* to) const {
  if constexpr (kHasGroups) {
    if (!Search::kRepeats && !seen.has_owners())
      return for_each_block<GroupWorker>(kMostPoints, [&](GroupWorker& worker, const Block& block) {
        block.for_each_group(worker, [&](const std::size_t* ids, std::span<const PointQuery> group) {
          std::uint32_t counts[kGroup];
          worker.group.count(group, ids, seen, worker.checkpoint, counts);
          for (std::size_t j = 0; j < group.size(); ++j) to[ids[j]] = counts[j];
        });
      });
  }
  for_each_list(
      [&](ListWorker& worker, std::size_t i, std::size_t length) {
        to[i] = std::int64_t(length);
        worker.found.clear();
      },
      [](const ListWorker&, const Block&) {});
}

template <class Search>
PointLists PointsQuery<Search>::list() const {
  const std::size_t n = points.size();
  PointLists lists;
  lists.offsets.assign(n + 1, 0);
  std::vector<LargeVector<Neighbour>> of_block(n_blocks(kMostListed));
  const auto set_length = [&](const ListWorker&, std::size_t i, std::size_t length) {
    lists.offsets[i + 1] = std::int64_t(length);
  };
  for_each_list(set_length, [&](const ListWorker& worker, const Block& block) {
    // Sort the lists into the order of the points.
    std::vector<std::size_t> place(block.end - block.begin + 1);
    for (std::size_t i = block.begin; i < block.end; ++i)
      place[i - block.begin + 1] = place[i - block.begin] + std::size_t(lists.offsets[i + 1]);
    LargeVector<Neighbour>& to = of_block[block.index];
    to.resize(worker.found.size());
    auto from = worker.found.begin();
    for (const std::uint32_t i : worker.order()) {
      const auto length = lists.offsets[block.begin + i + 1];
      std::copy_n(from, length, to.begin() + std::ptrdiff_t(place[i]));
      from += length;
    }
  });
  for (std::size_t i = 0; i < n; ++i) lists.offsets[i + 1] += lists.offsets[i];
  const auto n_found = std::size_t(lists.offsets[n]);
  for (Buffer<float>* column : {&lists.distance, &lists.s}) column->reset(n_found), column->set_size(n_found);
  lists.row.reset(n_found);
  lists.row.set_size(n_found);
  const NearestColumns columns{lists.distance.data(), lists.row.data(), lists.s.data()};
  std::size_t at = 0;
  for (LargeVector<Neighbour>& found : of_block) {
    for (const Neighbour& each : found) columns.set(at++, each, unit());
    found = {};
    progress.check();
  }
  return lists;
}

}  // namespace fastlines
