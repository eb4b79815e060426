// A list as a heap in place, with the last of its items on top, and its sort.
//
// A list has `comes_first(i, j)`, whether item i comes before item j, and `swap(i, j)`.
#pragma once

#include <cstdint>

namespace fastlines {

/// Move an item of the first `end` down until it comes after both below it.
template <class List>
void sift_down(List& list, std::uint64_t parent, std::uint64_t end) {
  for (;;) {
    std::uint64_t child = 2 * parent + 1;
    if (child >= end) return;
    if (child + 1 < end && list.comes_first(child, child + 1)) ++child;
    if (!list.comes_first(parent, child)) return;
    list.swap(parent, child);
    parent = child;
  }
}

/// Make a heap of the first n items.
template <class List>
void make_heap(List& list, std::uint64_t n) {
  for (std::uint64_t parent = n / 2; parent > 0;) sift_down(list, --parent, n);
}

/// Sort a heap of n items.
template <class List>
void sort_heap(List& list, std::uint64_t n) {
  for (std::uint64_t end = n; end > 1;) {
    list.swap(0, --end);
    sift_down(list, 0, end);
  }
}

/// Sort n items that are not a heap.
template <class List>
void sort_list(List& list, std::uint64_t n) {
  constexpr std::uint64_t max_insertions = 16;  // items; a heap is faster beyond, though by how much is not measured
  if (n <= max_insertions) {
    for (std::uint64_t i = 1; i < n; ++i)
      for (std::uint64_t j = i; j > 0 && list.comes_first(j, j - 1); --j) list.swap(j, j - 1);
    return;
  }
  make_heap(list, n);
  sort_heap(list, n);
}

}  // namespace fastlines
