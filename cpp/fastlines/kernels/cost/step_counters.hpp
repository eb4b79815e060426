// How many steps of each kind the kernels have taken. Counted only where FASTLINES_COUNTERS is defined, in a module of
// the benchmarks, on one thread (`fastlines-bench steps`); elsewhere `count_step` does nothing.
#pragma once

#include <cstdint>

namespace fastlines {

struct StepCounters {
  std::uint64_t rays = 0;      // prepared
  std::uint64_t bundles = 0;   // searched
  std::uint64_t nodes = 0;     // culled: 16 boxes
  std::uint64_t leaves = 0;    // culled: 16 pieces
  std::uint64_t pieces = 0;    // that survived
  std::uint64_t segments = 0;  // set up to be seen by a bundle
  std::uint64_t lines = 0;     // seen from afar by sixteen rays
  std::uint64_t packs = 0;     // exact tests of sixteen
  std::uint64_t tests = 0;     // exact tests of one ray and one segment
};

#if defined(FASTLINES_COUNTERS)
inline StepCounters steps;
inline void count_step(std::uint64_t StepCounters::* what, std::uint64_t n = 1) { steps.*what += n; }
#else
inline void count_step(std::uint64_t StepCounters::*, std::uint64_t = 1) {}
#endif

}  // namespace fastlines
