// How long each step of the kernels takes alone: the same few blocks and rays again and again, from the nearest cache,
// with nothing to wait for. The sum over the steps of a query is a lower bound for what the query takes.
#pragma once

#include <chrono>
#include <stdexcept>

#include "fastlines/kernels/thick.hpp"

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
inline StepTimings measure_steps(const WideView& tree, const RayBatch& batch) {
  constexpr std::uint32_t kFew = 8;
  std::uint32_t ids[kLanes], sum = 0;
  for (std::uint32_t i = 0; i < kLanes; ++i) ids[i] = i;
  const auto rays = std::make_unique<RayLanes>();
  const auto bundle = std::make_unique<Bundle>();
  const auto lines = std::make_unique<LinesBeside>();
  rays->fill(batch, tree.frame, kLanes, ids);
  CullRay cull[kWidth];
  cull_rays(*rays, 0, cull);
  if (!bundle->gather(*rays, 0, kLanes, tree.box)) throw std::invalid_argument("the first 64 rays are not coherent");
  bundle->look(rays->t_max);
  std::uint32_t prims[kWidth];
  for (std::uint32_t i = 0; i < kWidth; ++i) prims[i] = tree.leaves[0].first_ref + i % tree.leaves[0].n_refs;
  for (std::uint32_t& prim : prims) prim = tree.refs[prim].prim;
  lines->take(tree, prims, *bundle);
  const auto along = [&](int j) { return Vec3{lines->along[0][j], lines->along[1][j], lines->along[2][j]}; };
  const auto start = [&](int j) { return Vec3{lines->start[0][j], lines->start[1][j], lines->start[2][j]}; };

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
                    rays->fill(batch, tree.frame, kLanes, ids);
                    keep_all(rays.get());
                  },
                  64) /
              kLanes;
  timed.node = time_of([&](int i) {
    Float16 enter;
    sum += cull_node(cull[std::uint32_t(i) % kFew], tree.nodes[0], 1e9f, enter);
    keep(sum);
  });
  timed.leaf = time_of([&](int i) {
    const Across& ray = cull[std::uint32_t(i) % kFew].across;
    sum += cull_leaf(ray, tree.leaves[0], place_of(tree.leaves[0], ray));
    keep(sum);
  });
  timed.segment = time_of(
                      [&](int) {
                        lines->take(tree, prims, *bundle);
                        keep_all(lines.get());
                      },
                      256) /
                  kWidth;
  timed.line = time_of(
                   [&](int) {
                     lines->look(*bundle, kWidth, [&](int, int, std::uint32_t near) { sum += near; });
                     keep_all(lines.get());
                     keep(sum);
                   },
                   256) /
               (kWidth * (kLanes / kWidth));
  timed.pack = time_of([&](int i) {
    const Rays16 sixteen(*rays, i % 4 * kWidth);
    const int j = i / 4 % kWidth;
    sum += closest_approach(sixteen, see<Float16>(sixteen, start(j), along(j))).hit.bits();
    keep(sum);
  });
  const Ray ray = prepare(batch[0], tree.frame);
  timed.test = time_of([&](int i) {
    sum += closest_approach(ray, see<float>(ray, start(i % kWidth), along(i % kWidth))).hit;
    keep(sum);
  });
  return timed;
}

}  // namespace fastlines
