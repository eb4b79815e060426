// How long each step of the kernels takes alone: the same few blocks and rays again and again, from the nearest cache,
// with nothing to wait for. The sum over the steps of a query is a lower bound for what the query takes.
#pragma once

#include <chrono>
#include <stdexcept>

#include "fastlines/kernels/traverse/bundle_traversal.hpp"

namespace fastlines {

/// Nanoseconds.
struct StepTimings {
  double cycle;    // of the processor: one addition after the other
  double ray;      // to prepare
  double node;     // 16 boxes
  double leaf;     // 16 pieces
  double segment;  // to set up for a bundle
  double line;     // seen from afar by sixteen rays
  double pack;     // an exact test of sixteen
  double test;     // an exact test of one
};

/// Keep the compiler from leaving out what is timed.
template <class T>
inline void keep(T& value) {
  asm volatile("" : "+r"(value));
}

/// Keep it from leaving out what has been written there.
template <class T>
inline void keep_all(T* written) {
  asm volatile("" : : "r"(written) : "memory");
}

/// Nanoseconds a step, the best of some runs of `step(i)`.
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

/// For a tree that is not empty, and at least 64 coherent rays.
inline StepTimings measure_steps(const WideBvhView<Segments>& tree, const RayBatch& batch) {
  constexpr std::uint32_t kFew = 8;
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
  const auto lanes_at = [&](int j) {
    Lanes<Segments, float> found;
    for (int k = 0; k < Segments::kLanes; ++k) found[k] = lines->lanes[k][j];
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
    sum += cull_node(cull[std::uint32_t(i) % kFew], tree.nodes[0], 1e9f, enter);
    keep(sum);
  });
  timed.leaf = time_of([&](int i) {
    const ProjectedRay& ray = cull[std::uint32_t(i) % kFew].across;
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
  timed.pack = time_of([&](int i) {
    const PacketView sixteen(*rays, i % 4 * kSimdWidth);
    const int j = i / 4 % kSimdWidth;
    sum += Segments::test<FloatX16>(sixteen, lanes_at(j)).closest.hit.bits();
    keep(sum);
  });
  const Ray ray = prepare(batch[0], tree.frame);
  timed.test = time_of([&](int i) {
    sum += Segments::test<float>(ray, lanes_at(i % kSimdWidth)).closest.hit;
    keep(sum);
  });
  return timed;
}

}  // namespace fastlines
