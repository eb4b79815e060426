// Sets of the 64 lanes of a group, one bit each.
#pragma once

#include <bit>
#include <cstdint>

#include "../rays/ray_group.hpp"

namespace fastlines {

/// Lanes [first, first + n), n < 64.
inline std::uint64_t lane_range(int first, int n) { return ((std::uint64_t(1) << n) - 1) << first; }

/// The lanes that pass `test(first)`, which returns a mask of the packet that begins at lane `first`.
template <class Test>
std::uint64_t lanes_where(const Test& test) {
  std::uint64_t lanes = 0;
  for (int first = 0; first < kGroupSize; first += kSimdWidth) lanes |= std::uint64_t(test(first).bits()) << first;
  return lanes;
}

/// Call act(lane) for each lane of the set, in ascending order.
template <class Act>
[[gnu::always_inline]] inline void for_each_lane(std::uint64_t lanes, const Act& act) {
  for (; lanes; lanes &= lanes - 1) act(std::uint32_t(std::countr_zero(lanes)));
}

}  // namespace fastlines
