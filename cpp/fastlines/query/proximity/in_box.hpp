// The primitives in each of some regions: lists of their ids, and brute force, which defines them.
#pragma once

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "../../memory/large_vector.hpp"
#include "../../parallel/parallel_for.hpp"
#include "../../primitives/region.hpp"

namespace fastlines {

/// The ids of the primitives in region i, rising, are those from offsets[i] up to offsets[i + 1].
struct InBoxLists {
  LargeVector<std::int64_t> offsets, prims;
};

/// Ids that a thread collects for some regions.
using Ids = std::vector<std::uint32_t>;

/// Sort the ids from `first` on, and keep each once. Many are marked in a bit for each of the n_prims primitives.
inline void keep_distinct(Ids& ids, std::size_t first, std::size_t n_prims) {
  constexpr std::size_t sorted_of = 256;  // primitives for each id that is worth a bit
  const auto begin = ids.begin() + std::ptrdiff_t(first);
  if (sorted_of * (ids.size() - first) < n_prims) {
    std::sort(begin, ids.end());
    ids.erase(std::unique(begin, ids.end()), ids.end());
    return;
  }
  std::vector<std::uint64_t> marks((n_prims + 63) / 64);
  for (auto id = begin; id != ids.end(); ++id) marks[*id / 64] |= std::uint64_t(1) << (*id % 64);
  ids.resize(first);
  for (std::size_t i = 0; i < marks.size(); ++i)
    for (std::uint64_t word = marks[i]; word; word &= word - 1)
      ids.push_back(std::uint32_t(64 * i + std::size_t(std::countr_zero(word))));
}

/// List the primitives in each region. `make()` returns the search of a thread: search(region, ids, checkpoint) appends
/// ids, in any order, perhaps several times.
template <class Make>
InBoxLists list_in_boxes(std::span<const Region> regions, std::size_t n_prims, unsigned n_threads, Progress& progress,
                         Make&& make) {
  const std::size_t chunk_size = regions.size() < 4096 ? 1 : 16,
                    n_chunks = (regions.size() + chunk_size - 1) / chunk_size;
  InBoxLists lists;
  lists.offsets.resize(regions.size() + 1);
  std::vector<Ids> found(n_chunks);
  struct Worker {
    Checkpoint checkpoint;
    decltype(make()) search;
  };
  parallel_for_chunks(
      regions.size(), chunk_size, n_threads, progress, [&] { return Worker{Checkpoint(progress), make()}; },
      [&](Worker& worker, std::size_t begin, std::size_t end) {
        Ids& ids = found[begin / chunk_size];
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t first = ids.size();
          worker.checkpoint.pass();
          worker.search(regions[i], ids, worker.checkpoint);
          keep_distinct(ids, first, n_prims);
          lists.offsets[i + 1] = std::int64_t(ids.size() - first);
        }
      });

  for (std::size_t i = 0; i < regions.size(); ++i) lists.offsets[i + 1] += lists.offsets[i];
  lists.prims.reserve(std::size_t(lists.offsets.back()));
  for (Ids& ids : found) {
    progress.check();
    lists.prims.insert(lists.prims.end(), ids.begin(), ids.end());
    ids = {};
  }
  return lists;
}

/// Tests every primitive with a region: the reference for the answers of all trees.
template <RayPrimitive P>
struct BruteForceInBox {
  const P& prims;
  bool surface;

  void operator()(const Region& region, Ids& ids, Checkpoint& checkpoint) const {
    constexpr std::size_t at_once = 1024;  // primitives between two checkpoints
    for (std::size_t first = 0; first < prims.size(); first += at_once) {
      const std::size_t end = std::min(first + at_once, prims.size());
      checkpoint.pass(end - first);
      for (std::size_t prim = first; prim < end; ++prim)
        if (is_in(region, prims.item(std::uint32_t(prim)), surface)) ids.push_back(std::uint32_t(prim));
    }
  }
};

}  // namespace fastlines
