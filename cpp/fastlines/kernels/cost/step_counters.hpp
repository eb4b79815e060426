// Counts the steps of the kernels, by kind. Only a module of the benchmarks (`fastlines-bench steps`) defines
// FASTLINES_COUNTERS and counts, on one thread. Elsewhere `count_step` does nothing.
#pragma once

#include <cstdint>

namespace fastlines {

struct StepCounters {
  std::uint64_t rays = 0;      ///< prepared rays
  std::uint64_t bundles = 0;   ///< traced bundles
  std::uint64_t nodes = 0;     ///< culls of 16 boxes
  std::uint64_t leaves = 0;    ///< culls of 16 pieces
  std::uint64_t pieces = 0;    ///< pieces that survived culling
  std::uint64_t segments = 0;  ///< segments set up for the line test of a bundle
  std::uint64_t lines = 0;     ///< line tests of a segment and 16 rays
  std::uint64_t packets = 0;   ///< exact tests of 16 pairs
  std::uint64_t tests = 0;     ///< exact tests of one ray and one segment
};

#if defined(FASTLINES_COUNTERS)
inline StepCounters steps;
inline void count_step(std::uint64_t StepCounters::* counter, std::uint64_t n = 1) { steps.*counter += n; }
#else
inline void count_step(std::uint64_t StepCounters::*, std::uint64_t = 1) {}
#endif

}  // namespace fastlines
