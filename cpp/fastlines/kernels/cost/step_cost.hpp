// What steps of the kernels cost, in cycles, and samples of it.
#pragma once

#include <cstdint>

namespace fastlines {

/// What steps take in a bundle, and single in a wave or a stream, in cycles: with their share of all that is in no
/// step, so that they sum to what first hits take. Lists take up to twice as much, both ways. Only so good that ways
/// which differ by a half are told apart.
struct BundleStepCost {
  static constexpr std::uint64_t kRay = 60, kNode = 80, kLeaf = 65, kSegment = 45, kLine = 12, kPack = 90;
};
struct SingleStepCost {
  static constexpr std::uint64_t kRay = 190, kRoot = 35, kNode = 65, kLeaf = 45, kTest = 50, kPack = 225;
};

/// Some rays, and what they have cost.
struct Sample {
  std::uint64_t cost = 0, rays = 0;

  void operator+=(const Sample& other) {
    cost += other.cost;
    rays += other.rays;
  }
  float per_ray() const { return float(cost) / float(rays); }
};

}  // namespace fastlines
