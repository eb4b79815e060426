// A vector whose memory comes from the page pool.
#pragma once

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

/// Reserves room for n more elements. Unused capacity costs only address space, but growing copies. So a vector of less
/// than 2 MB reserves eight times as much as it needs, a larger one twice as much.
template <class T>
void reserve_more(LargeVector<T>& vector, std::size_t n) {
  constexpr std::size_t small = std::size_t(1) << 21;  // bytes
  if (const std::size_t size = vector.size() + n; size > vector.capacity())
    vector.reserve(size * (size * sizeof(T) < small ? 8 : 2));
}

}  // namespace fastlines
