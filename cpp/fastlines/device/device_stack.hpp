// The stack of a ray: its first entries in shared memory, the others in local memory.
//
// The stack has the room that the tree needs: kernels are compiled for it, after one pass over the nodes
// (src/fastlines/cuda/scene.py). Shared memory is faster than local memory, but there is little of it: a block that
// takes more leaves room for fewer blocks.
#pragma once

#include "group.hpp"

#if !defined(FASTLINES_STACK)
/// Entries of the stack of each ray.
#define FASTLINES_STACK 256
#endif

#if !defined(FASTLINES_SHARED_STACK)
/// Entries of the stack of each ray that are in shared memory. How many are best is not measured yet.
#define FASTLINES_SHARED_STACK 0
#endif

namespace fastlines {

/// A node to visit, and where the ray enters it: t in the frame.
struct DeviceStackEntry {
  std::uint32_t node;
  float enter;
};

/// Entries in shared and in local memory.
inline constexpr int kSharedEntries =
    FASTLINES_SHARED_STACK < FASTLINES_STACK ? FASTLINES_SHARED_STACK : FASTLINES_STACK;
inline constexpr int kLocalEntries = FASTLINES_STACK - kSharedEntries;

/// Whether an entry is in shared memory.
constexpr bool is_shared(int place) { return kSharedEntries > 0 && (kLocalEntries == 0 || place < kSharedEntries); }

/// An entry in shared memory, of the calling thread or its group.
[[gnu::always_inline]] inline DeviceStackEntry& shared_entry(int place) {
  constexpr int room = kSharedEntries > 0 ? kSharedEntries : 1;
#if defined(__CUDACC__)
  constexpr int n_rays = FASTLINES_BLOCK / kGroup, max_bytes = 48 * 1024;
  static_assert(room * n_rays * int(sizeof(DeviceStackEntry)) <= max_bytes,
                "FASTLINES_SHARED_STACK is too large: a block has 48 KB of shared memory");
  __shared__ DeviceStackEntry entries[room * n_rays];
  // Threads of a warp, or lanes of a group, use different banks.
  const int ray = int(threadIdx.x) / kGroup;
  return entries[kGroup > 1 ? ray * room + place : place * n_rays + ray];
#else
  static thread_local DeviceStackEntry entries[room];
  return entries[place];
#endif
}

/// The stack of a thread.
class ThreadStack {
 public:
  DeviceStackEntry get(int place) const {
    if (is_shared(place)) return shared_entry(place);
    return local_[place - kSharedEntries];
  }
  void set(int place, const DeviceStackEntry& entry) {
    if (is_shared(place))
      shared_entry(place) = entry;
    else
      local_[place - kSharedEntries] = entry;
  }

 private:
  DeviceStackEntry local_[kLocalEntries > 0 ? kLocalEntries : 1];
};

/// The stack of a group. Its lanes take turns to keep the entries in local memory.
class GroupStack {
 public:
  DeviceStackEntry get(int place) const {
    if (is_shared(place)) return shared_entry(place);
    const int row = (place - kSharedEntries) / kGroupLanes, keeper = (place - kSharedEntries) % kGroupLanes;
    GroupLanes<std::uint32_t> node;
    GroupLanes<float> enter;
    for_lanes([&](int lane) {
      node[lane] = local_[lane].rows[row].node;
      enter[lane] = local_[lane].rows[row].enter;
    });
    return {shuffle(node, keeper), shuffle(enter, keeper)};
  }

  /// Set an entry from each lane of a mask, at its place: one of as many from `first` on.
  void set(std::uint32_t from, int first, const GroupLanes<int>& places, const GroupLanes<std::uint32_t>& node,
           const GroupLanes<float>& enter) {
    if (is_shared(first)) {
      sync_group();  // all lanes have read what was there
      for_lanes([&](int lane) {
        if ((from >> lane & 1) && is_shared(places[lane])) shared_entry(places[lane]) = {node[lane], enter[lane]};
      });
      sync_group();
    }
    if (is_shared(first + count_bits(from) - 1)) return;
    for (; from; from &= from - 1) {
      const int giver = lowest_bit(from), place = shuffle(places, giver);
      if (is_shared(place)) continue;
      const DeviceStackEntry entry{shuffle(node, giver), shuffle(enter, giver)};
      const int row = (place - kSharedEntries) / kGroupLanes, keeper = (place - kSharedEntries) % kGroupLanes;
      for_lanes([&](int lane) {
        if (lane == keeper) local_[lane].rows[row] = entry;
      });
    }
  }

 private:
  struct Rows {
    DeviceStackEntry rows[kLocalEntries > 0 ? (kLocalEntries + kGroupLanes - 1) / kGroupLanes : 1];
  };

  GroupLanes<Rows> local_;
};

}  // namespace fastlines
