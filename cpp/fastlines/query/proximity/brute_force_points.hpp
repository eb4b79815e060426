// Tests every primitive with a point: the reference for the answers of all trees.
#pragma once

#include "../../parallel/progress.hpp"
#include "point_collectors.hpp"

namespace fastlines {

/// Tests all primitives in order of their ids, each as a whole.
template <RayPrimitive P>
struct BruteForcePoints {
  static constexpr bool kRepeats = false;

  const P& prims;
  Frame frame;

  struct Scratch {};

  /// The most steps that a point may take, for progress.
  std::size_t n_steps() const { return prims.size(); }

  template <PointCollector C>
  void operator()(const PointQuery& query, C& to, Scratch&, Checkpoint& checkpoint) const {
    constexpr std::size_t at_once = 1024;  // primitives between two checkpoints
    for (std::size_t first = 0; first < prims.size(); first += at_once) {
      const std::size_t end = std::min(first + at_once, prims.size());
      checkpoint.pass(end - first);
      for (std::size_t i = first; i < end; ++i) {
        const auto row = std::uint32_t(i);
        const NearestPoint<float> found = nearest_point<P>(query, point_fields_of<P>(prims.item(row), frame));
        if (found.within) to.add({found.distance, row, found.s}, Reference{row});
      }
    }
  }
};

}  // namespace fastlines
