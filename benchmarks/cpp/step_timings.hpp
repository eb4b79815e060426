// Times each step of the kernels alone: on a few blocks and rays that stay in the L1 cache, without cache misses. The
// sum over all steps of a query is a lower bound for its time.
#pragma once

#include <chrono>
#include <stdexcept>

#include "fastlines/kernels/traverse/bundle_traversal.hpp"

namespace fastlines {

/// The nanoseconds of each step.
struct StepTimings {
  double cycle;    // of the processor: one of a chain of dependent additions
  double ray;      // preparing a ray
  double node;     // culling 16 boxes with one ray
  double leaf;     // culling 16 pieces with one ray
  double segment;  // loading a segment for a bundle
  double line;     // the line test of a segment against 16 rays of a bundle
  double packet;   // an exact test of 16 pairs, one per lane
  double test;     // an exact test of one ray and one segment
};

/// Stops the compiler from removing the computation of a value.
template <class T>
inline void keep(T& value) {
  asm volatile("" : "+r"(value));
}

/// Stops the compiler from removing writes to memory.
template <class T>
inline void keep_all(T* written) {
  asm volatile("" : : "r"(written) : "memory");
}

/// The nanoseconds per call of step(i): the minimum over 40 runs of n calls each.
template <class Step>
double time_of(Step&& step, int n = 4096) {
  using Clock = std::chrono::steady_clock;
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 40; ++run) {
    const auto start = Clock::now();
    for (int i = 0; i < n; ++i) step(i);
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - start).count() / n);
  }
  return best;
}

/// Times all steps on the first blocks of a tree that is not empty. Takes the first 64 rays, which must be coherent;
/// throws std::invalid_argument otherwise.
inline StepTimings measure_steps(const WideBvhView<Segments>& tree, const RayBatch& batch) {
  constexpr std::uint32_t kCullRays = 8;  // single rays, alternated in culling
  std::uint32_t ids[kGroupSize], sum = 0;
  for (std::uint32_t i = 0; i < kGroupSize; ++i) ids[i] = i;
  const auto rays = std::make_unique<RayGroup>();
  const auto bundle = std::make_unique<RayBundle>();
  const auto lines = std::make_unique<BundleLineTest<Segments>>();
  rays->fill(batch, tree.frame, kGroupSize, ids);
  CullRay cull[kSimdWidth];
  cull_rays(*rays, 0, cull);
  if (!bundle->try_fit(*rays, 0, kGroupSize, tree.box))
    throw std::invalid_argument("the first 64 rays are not coherent");
  bundle->update_depths(rays->t_max);
  std::uint32_t prims[kSimdWidth];
  for (std::uint32_t i = 0; i < kSimdWidth; ++i) prims[i] = tree.leaves[0].first_ref + i % tree.leaves[0].n_refs;
  for (std::uint32_t& prim : prims) prim = tree.refs[prim].prim;
  lines->load(tree, prims, *bundle);
  const auto fields_at = [&](int j) {
    Fields<Segments, float> found;
    for (int k = 0; k < Segments::kFields; ++k) found[k] = lines->fields[k][j];
    return found;
  };

  StepTimings timed;
  timed.cycle = time_of([&](int) {
                  for (int k = 0; k < 16; ++k) {
                    ++sum;
                    keep(sum);
                  }
                }) /
                16;
  timed.ray = time_of(
                  [&](int) {
                    rays->fill(batch, tree.frame, kGroupSize, ids);
                    keep_all(rays.get());
                  },
                  64) /
              kGroupSize;
  timed.node = time_of([&](int i) {
    FloatX16 enter;
    sum += cull_node(cull[std::uint32_t(i) % kCullRays], tree.nodes[0], 1e9f, enter);
    keep(sum);
  });
  timed.leaf = time_of([&](int i) {
    const ProjectedRay& ray = cull[std::uint32_t(i) % kCullRays].projected;
    sum += cull_leaf(ray, tree.leaves[0], leaf_offset(tree.leaves[0], ray));
    keep(sum);
  });
  timed.segment = time_of(
                      [&](int) {
                        lines->load(tree, prims, *bundle);
                        keep_all(lines.get());
                      },
                      256) /
                  kSimdWidth;
  timed.line = time_of(
                   [&](int) {
                     lines->test(*bundle, kSimdWidth, [&](int, int, std::uint32_t near) { sum += near; });
                     keep_all(lines.get());
                     keep(sum);
                   },
                   256) /
               (kSimdWidth * (kGroupSize / kSimdWidth));
  timed.packet = time_of([&](int i) {
    const PacketView packet(*rays, i % 4 * kSimdWidth);
    const int j = i / 4 % kSimdWidth;
    sum += Segments::test<FloatX16>(packet, fields_at(j)).closest.hit.bits();
    keep(sum);
  });
  const Ray ray = prepare(batch[0], tree.frame);
  timed.test = time_of([&](int i) {
    sum += Segments::test<float>(ray, fields_at(i % kSimdWidth)).closest.hit;
    keep(sum);
  });
  return timed;
}

}  // namespace fastlines
