// What the steps of a kernel cost, in cycles, and samples of the cost of rays.
#pragma once

#include <cstdint>

namespace fastlines {

/// Cycles per step of a bundle; `fastlines-bench steps` counts and times the steps. Each cost includes its share of the
/// time outside of steps, so that the costs add up to the time of first hits. Lists take up to twice as long with
/// either kind of kernel. The costs are accurate enough to tell apart methods that differ by 50 %.
struct BundleStepCost {
  static constexpr std::uint64_t kRay = 60;      ///< a ray of the bundle
  static constexpr std::uint64_t kNode = 80;     ///< cull 16 boxes
  static constexpr std::uint64_t kLeaf = 65;     ///< cull 16 pieces
  static constexpr std::uint64_t kSegment = 45;  ///< set up the line test of a segment
  static constexpr std::uint64_t kLine = 12;     ///< the line test of a segment and 16 rays
  static constexpr std::uint64_t kPacket = 90;   ///< an exact test of 16 pairs
};

/// Cycles per step of a wavefront or a stream, measured as `BundleStepCost` is.
struct SingleStepCost {
  static constexpr std::uint64_t kRay = 190;     ///< a ray
  static constexpr std::uint64_t kRoot = 35;     ///< cull the root for a ray
  static constexpr std::uint64_t kNode = 65;     ///< cull 16 boxes
  static constexpr std::uint64_t kLeaf = 45;     ///< cull 16 pieces
  static constexpr std::uint64_t kTest = 50;     ///< a survivor: a pair of a ray and a segment
  static constexpr std::uint64_t kPacket = 225;  ///< an exact test of 16 pairs
};

/// What some rays have cost together, in cycles.
struct Sample {
  std::uint64_t cost = 0, rays = 0;

  void operator+=(const Sample& other) {
    cost += other.cost;
    rays += other.rays;
  }
  /// Precondition: rays > 0.
  float per_ray() const { return float(cost) / float(rays); }
};

}  // namespace fastlines
