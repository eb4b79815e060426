// A group of threads that takes one ray: a thread alone, or 16 lanes, half a warp.
//
// What is equal in all lanes of a group is a plain variable. What differs is in `GroupLanes`: a register on a GPU, an
// array on the host, where the first thread of a group runs all its lanes. The work of lanes is a call of `for_lanes`;
// between such calls, ballots and shuffles exchange values.
//
// The two groups of a warp follow different rays and diverge. So all masks name the lanes of one group only.
#pragma once

#include "thread.hpp"

#if !defined(FASTLINES_GROUP)
/// Threads that take a ray: 1, or 16. Which is faster is not measured yet.
#define FASTLINES_GROUP 1
#endif

namespace fastlines {

inline constexpr int kGroup = FASTLINES_GROUP;
static_assert(kGroup == 1 || kGroup == 16, "FASTLINES_GROUP must be 1 or 16");

/// The lanes of a larger group.
inline constexpr int kGroupLanes = 16;

#if defined(__CUDACC__)

static_assert(kGroup == 1 || FASTLINES_BLOCK % 32 == 0,
              "FASTLINES_BLOCK must be a multiple of 32, the lanes of a warp");

/// A value of each lane.
template <class T>
struct GroupLanes {
  T value;

  T& operator[](int) { return value; }
  const T& operator[](int) const { return value; }
};

/// The first lane of the group in its warp.
inline int first_lane() { return int(threadIdx.x) & kGroupLanes; }

/// The lanes of the group in its warp.
inline std::uint32_t group_mask() { return 0xffffu << first_lane(); }

/// Call work(lane) for each lane of the group.
template <class Work>
inline void for_lanes(const Work& work) {
  work(int(threadIdx.x) % kGroupLanes);
}

/// A mask of the lanes that vote.
inline std::uint32_t ballot(const GroupLanes<bool>& votes) {
  return __ballot_sync(group_mask(), votes.value) >> first_lane() & 0xffffu;
}

/// The value of one lane.
template <class T>
inline T shuffle(const GroupLanes<T>& values, int lane) {
  return __shfl_sync(group_mask(), values.value, lane, kGroupLanes);
}

/// Let each lane see what the others have written.
inline void sync_group() { __syncwarp(group_mask()); }

/// Whether the calling thread collects the hits: the first of its group.
inline bool is_leader() { return threadIdx.x % kGroup == 0; }

/// The value of the leader.
inline float from_leader(float value) { return __shfl_sync(group_mask(), value, 0, kGroupLanes); }

/// Whether the calling thread runs lanes; on a GPU each thread is one.
inline bool runs_lanes() { return true; }

#else

/// A value of each lane.
template <class T>
struct GroupLanes {
  T values[kGroupLanes];

  T& operator[](int lane) { return values[lane]; }
  const T& operator[](int lane) const { return values[lane]; }
};

/// Call work(lane) for each lane of the group.
template <class Work>
inline void for_lanes(const Work& work) {
  for (int lane = 0; lane < kGroupLanes; ++lane) work(lane);
}

/// A mask of the lanes that vote.
inline std::uint32_t ballot(const GroupLanes<bool>& votes) {
  std::uint32_t mask = 0;
  for (int lane = 0; lane < kGroupLanes; ++lane) mask |= std::uint32_t(votes[lane]) << lane;
  return mask;
}

/// The value of one lane.
template <class T>
inline T shuffle(const GroupLanes<T>& values, int lane) {
  return values[lane];
}

/// Let each lane see what the others have written.
inline void sync_group() {}

/// Whether the calling thread collects the hits.
inline bool is_leader() { return true; }

/// The value of the leader.
inline float from_leader(float value) { return value; }

/// Whether the calling thread runs lanes; on the host the first thread of a group runs all of them.
inline bool runs_lanes() { return thread_index() % kGroup == 0; }

#endif

}  // namespace fastlines
