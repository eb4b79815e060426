// What kernels are given: plain records of pointers and numbers, which src/fastlines/cuda/records.py packs alike.
#pragma once

#include "../layout/wide_blocks.hpp"
#include "../rays/frame.hpp"
#include "../rays/hit.hpp"

namespace fastlines {

/// A layout and its primitives in the memory of the device.
struct DeviceScene {
  const WideNode* nodes;
  const WideLeaf* leaves;
  const WideRef* refs;
  const float* items;  ///< the primitives, as the caller gave them
  Frame frame;         ///< as in a `WideBvhView`: the overhang covers the rounding of the radii
};
static_assert(sizeof(DeviceScene) == 56);

/// A batch of rays in the memory of the device, as in `RayBatch`. A step is how many floats the next ray's value is
/// away: 0 if there is one for all. Only kernels of primitives for rays with a spread read it.
struct DeviceRays {
  const float *origins, *directions, *radius, *t_min, *t_max, *spread;
  const std::uint32_t* order;  ///< the order in which threads take rays; null for that of the arrays
  std::uint64_t n;
  std::uint32_t origin_step, direction_step, radius_step, t_min_step, t_max_step, spread_step;
};
static_assert(sizeof(DeviceRays) == 88);

/// What rays must be for a scene, as src/fastlines/query/rays.py checks them.
struct DeviceLimits {
  double low[3], high[3];  ///< the box of the scene
  double largest_radius;
};
static_assert(sizeof(DeviceLimits) == 56);

/// Hits as columns in the memory of the device; t_out may be null.
using DeviceHits = HitColumns;
static_assert(sizeof(DeviceHits) == 40);

/// Lists of hits: those of ray i are at offsets[i] up to offsets[i + 1].
struct DeviceLists {
  const std::int64_t* offsets;
  DeviceHits hits;
  /// How many hits each list has in the end: fewer than there is room for, if rays find primitives several times. May
  /// be null.
  std::int64_t* n_hits;
};
static_assert(sizeof(DeviceLists) == 56);

}  // namespace fastlines
