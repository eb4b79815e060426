// Regions of interest as arrays, and lists of what is in them.
#pragma once

#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "fastlines/query/proximity/in_box.hpp"
#include "fastlines/rays/ray_batch.hpp"
#include "watch.hpp"

namespace fastlines {

/// Offsets, and primitives.
using InBoxTuple = std::tuple<Output<std::int64_t>, Output<std::int64_t>>;

/// The regions of corners, rows of x, y and z.
inline std::vector<Region> regions_of(const Input<double>& low, const Input<double>& high) {
  struct Corner {
    double x[3];
  };
  const auto lows = rows<Corner>(low), highs = rows<Corner>(high);
  std::vector<Region> regions(lows.size());
  for (std::size_t i = 0; i < lows.size(); ++i) {
    std::copy_n(lows[i].x, 3, regions[i].lo);
    std::copy_n(highs[i].x, 3, regions[i].hi);
  }
  return regions;
}

/// The lists of regions. A search passes up to `n_steps` checkpoints for each.
template <class Make>
InBoxTuple in_boxes(const Input<double>& low, const Input<double>& high, std::size_t n_prims, std::size_t n_steps,
                    unsigned n_threads, const nanobind::object& progress, Make&& make) {
  const std::vector<Region> regions = regions_of(low, high);
  const bool is_long = may_be_long(regions.size(), n_prims);
  InBoxLists lists;
  watch_if(is_long, progress, [&](Progress& watched) {
    watched.per_step = 1.0 / (double(regions.size()) * double(n_steps + 1));
    lists = list_in_boxes(regions, n_prims, is_long ? n_threads : 1, watched, make);
  });
  return {adopt<std::int64_t>(std::move(lists.offsets)), adopt<std::int64_t>(std::move(lists.prims))};
}

}  // namespace fastlines
