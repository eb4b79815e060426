// Merges the answers of the parts of a whole about points: each part answers some of the points, by numbers of
// primitives in the whole. No primitive is in two parts, and ranks are distances, then numbers.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../../memory/buffer.hpp"
#include "../../memory/large_vector.hpp"
#include "../../parallel/parallel_for.hpp"
#include "../../rays/hit_order.hpp"

namespace fastlines {

/// The lists of a part: the points that it answers, and what it lists for each of them. `distance` and `s` are empty
/// where lists have none, and ranks are numbers alone.
struct PartLists {
  std::span<const std::int64_t> points, offsets, prims;
  std::span<const float> distance, s;
};

/// Lists of all points: those of point i are entries offsets[i] up to offsets[i + 1].
struct MergedLists {
  LargeVector<std::int64_t> offsets;
  Buffer<std::int64_t> prims;
  Buffer<float> distance, s;
};

/// An entry of a list.
struct ListEntry {
  std::int64_t prim;
  float distance, s;
  bool operator<(const ListEntry& other) const {
    return distance != other.distance ? distance < other.distance : prim < other.prim;
  }
};

/// The lists of n points, each sorted.
inline MergedLists merge_lists(std::size_t n_points, std::span<const PartLists> parts, bool has_distance,
                               unsigned n_threads, Progress& progress) {
  MergedLists to;
  to.offsets.assign(n_points + 1, 0);
  for (const PartLists& part : parts)
    for (std::size_t at = 0; at < part.points.size(); ++at)
      to.offsets[std::size_t(part.points[at]) + 1] += part.offsets[at + 1] - part.offsets[at];
  for (std::size_t i = 0; i < n_points; ++i) to.offsets[i + 1] += to.offsets[i];
  const auto n = std::size_t(to.offsets[n_points]);
  to.prims.reset(n);
  to.prims.set_size(n);
  for (Buffer<float>* column : {&to.distance, &to.s}) {
    column->reset(has_distance ? n : 0);
    column->set_size(has_distance ? n : 0);
  }
  // Move the entries of each point together.
  LargeVector<std::int64_t> next(to.offsets.begin(), to.offsets.end());
  for (const PartLists& part : parts) {
    progress.check();
    for (std::size_t at = 0; at < part.points.size(); ++at) {
      std::int64_t& place = next[std::size_t(part.points[at])];
      const auto from = std::size_t(part.offsets[at]), count = std::size_t(part.offsets[at + 1]) - from;
      std::copy_n(part.prims.data() + from, count, to.prims.data() + place);
      if (has_distance) {
        std::copy_n(part.distance.data() + from, count, to.distance.data() + place);
        std::copy_n(part.s.data() + from, count, to.s.data() + place);
      }
      place += std::int64_t(count);
    }
  }
  // Sort those that are not.
  constexpr std::size_t chunk_size = 256;  // points
  parallel_for_chunks(
      n_points, chunk_size, n_threads, progress, [] { return std::vector<ListEntry>(); },
      [&](std::vector<ListEntry>& list, std::size_t begin, std::size_t end) {
        for (std::size_t point = begin; point < end; ++point) {
          const auto first = std::size_t(to.offsets[point]), last = std::size_t(to.offsets[point + 1]);
          list.clear();
          for (std::size_t at = first; at < last; ++at)
            list.push_back({to.prims[at], has_distance ? to.distance[at] : 0.0f, has_distance ? to.s[at] : 0.0f});
          if (std::is_sorted(list.begin(), list.end())) continue;
          std::sort(list.begin(), list.end());
          for (std::size_t at = first; at < last; ++at) {
            const ListEntry& entry = list[at - first];
            to.prims[at] = entry.prim;
            if (has_distance) to.distance[at] = entry.distance, to.s[at] = entry.s;
          }
        }
      });
  return to;
}

/// Entries of k for each point, sorted; infinity, −1 and 0 where there are fewer.
template <class Float, class Int>
struct NearestEntries {
  Float* distance;
  Int* prim;
  Float* s;
  std::size_t k;

  ListEntry entry(std::size_t i) const { return {prim[i], distance[i], s[i]}; }
};

/// Put what a part has found for some points among the k best of these.
inline void merge_nearest(const NearestEntries<float, std::int64_t>& best, std::span<const std::int64_t> points,
                          const NearestEntries<const float, const std::int64_t>& found) {
  const auto precedes = [](const ListEntry& a, const ListEntry& b) { return a.prim >= 0 && (b.prim < 0 || a < b); };
  std::vector<ListEntry> before(best.k);
  for (std::size_t row = 0; row < points.size(); ++row) {
    const std::size_t first = std::size_t(points[row]) * best.k;
    std::size_t from = row * found.k;
    const std::size_t end = from + found.k;
    // Most of what a further part finds is beyond the last of the best.
    if (from == end || !precedes(found.entry(from), best.entry(first + best.k - 1))) continue;
    for (std::size_t i = 0; i < best.k; ++i) before[i] = best.entry(first + i);
    auto other = before.begin();
    for (std::size_t i = first; i < first + best.k; ++i) {
      const bool takes = from < end && precedes(found.entry(from), *other);
      const ListEntry entry = takes ? found.entry(from++) : *other++;
      best.distance[i] = entry.distance;
      best.prim[i] = entry.prim;
      best.s[i] = entry.s;
    }
  }
}

}  // namespace fastlines
