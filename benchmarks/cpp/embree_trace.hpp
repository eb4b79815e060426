// Traces batches of rays through an Embree scene, as a caller who knows Embree well would.
#pragma once

#include "embree_scene.hpp"

namespace fastlines::peers {

struct Ray3 {
  float x, y, z;
};

/// Rays of unit direction, all with the same bounds.
struct Rays {
  std::span<const Ray3> origins, directions;
  float t_min, t_max;
};

/// How to trace: rays one by one (width 1) or in packets of 8 or 16 neighbours, with Embree's hint for coherent rays or
/// without.
struct TraceOptions {
  int width = 16;
  bool coherent = false;
  unsigned n_threads = 1;
};

/// The nearest hit of each ray: t (∞ = miss) and segment (−1 = miss).
void first_hits(const Scene& scene, const Rays& rays, const TraceOptions& options, float* t, std::int32_t* prim);

/// Whether each ray hits anything.
void any_hits(const Scene& scene, const Rays& rays, const TraceOptions& options, bool* found);

/// All hits in no order, one buffer per thread.
std::vector<HitBuffer> all_hits(const Scene& scene, const Rays& rays, const TraceOptions& options,
                                const Callbacks& callbacks);

/// The sums over all crossings of each ray with the beams of a scene of user geometry: kColours a ray. `powers` has as
/// many for each beam.
void gathers(const Scene& scene, const Rays& rays, const TraceOptions& options, const Gather& gather,
             const float* powers, const Callbacks& callbacks, float* sums);

}  // namespace fastlines::peers
