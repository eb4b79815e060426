// A vector whose memory comes from the page pool.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "page_pool.hpp"

namespace fastlines {

/// The allocator of LargeVector.
template <class T>
struct PageAllocator {
  using value_type = T;
  PageAllocator() = default;
  template <class Other>
  PageAllocator(const PageAllocator<Other>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(PagePool::allocate(n * sizeof(T))); }
  void deallocate(T* data, std::size_t) noexcept { PagePool::release(data); }
  bool operator==(const PageAllocator&) const { return true; }
};

template <class T>
using LargeVector = std::vector<T, PageAllocator<T>>;

/// Appends the elements of `from`, and frees them. The pages of large vectors are freed on the way.
template <class T>
void append_moved(LargeVector<T>& to, LargeVector<T>&& from) {
  constexpr std::size_t step = (std::size_t(1) << 23) / sizeof(T);  // elements
  for (std::size_t i = 0; i < from.size(); i += step) {
    const std::size_t end = std::min(i + step, from.size());
    to.insert(to.end(), from.begin() + std::ptrdiff_t(i), from.begin() + std::ptrdiff_t(end));
    PagePool::discard(from.data(), from.data() + end);
  }
  if (from.data()) PagePool::trim(from.data(), 0);
  LargeVector<T>().swap(from);
}

/// Reserves room for n more elements. Unused capacity costs only address space, but growing copies. So a vector of less
/// than 2 MB reserves eight times as much as it needs, a larger one twice as much.
template <class T>
void reserve_more(LargeVector<T>& vector, std::size_t n) {
  constexpr std::size_t small = std::size_t(1) << 21;  // bytes
  const std::size_t size = vector.size() + n;
  if (size <= vector.capacity()) return;
  LargeVector<T> larger;
  larger.reserve(size * (size * sizeof(T) < small ? 8 : 2));
  append_moved(larger, std::move(vector));
  vector = std::move(larger);
}

}  // namespace fastlines
