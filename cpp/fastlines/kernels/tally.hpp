// How many steps of each kind a thread's kernels have taken. Counted only where FASTLINES_TALLY is defined, in a module
// of its own (`fastlines bench steps`); elsewhere `tally` does nothing.
#pragma once

#include <cstdint>

namespace fastlines {

/// `rays` and `bundles` begun; blocks culled; `pieces` that survived their leaves; `lines` of 16 rays beside a segment
/// looked at from afar; `tests` of one segment with one ray, exact; `packs`, the same sixteen at a time.
struct Steps {
  std::uint64_t rays = 0, bundles = 0, nodes = 0, leaves = 0, pieces = 0, lines = 0, tests = 0, packs = 0;
};

#if defined(FASTLINES_TALLY)
inline Steps steps;
inline void tally(std::uint64_t Steps::* what, std::uint64_t n = 1) { steps.*what += n; }
#else
inline void tally(std::uint64_t Steps::*, std::uint64_t = 1) {}
#endif

}  // namespace fastlines
