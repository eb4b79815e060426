// Memory as large answers and the blocks of a layout want it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace fastlines {

/// Memory for std::free: aligned, and in huge pages where that saves faults.
inline void* allocate(std::size_t n_bytes) {
  constexpr std::size_t kBlock = 128, kHuge = std::size_t(1) << 21;
  const std::size_t alignment = n_bytes >= 2 * kHuge ? kHuge : kBlock;
  void* const data = std::aligned_alloc(alignment, (n_bytes / alignment + 1) * alignment);
  if (!data) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (alignment == kHuge) madvise(data, n_bytes, MADV_HUGEPAGE);  // a hint: if it is refused, nothing is lost
#endif
  return data;
}

/// Gives out memory in pieces of large blocks, to any thread. A block lives as long as any piece of it.
class Arena {
 public:
  std::shared_ptr<std::byte> take(std::size_t n_bytes) {
    const std::size_t size = (n_bytes + kPiece - 1) / kPiece * kPiece;
    const std::lock_guard lock(mutex_);
    if (left_ < size) {
      const std::size_t n_bytes_of_block = std::max(size, next_);
      block_.reset(static_cast<std::byte*>(allocate(n_bytes_of_block)), [](std::byte* data) { std::free(data); });
      at_ = block_.get();
      left_ = n_bytes_of_block;
      next_ = std::min(2 * next_, kLargest);
    }
    std::shared_ptr<std::byte> piece(block_, at_);
    at_ += size;
    left_ -= size;
    return piece;
  }

 private:
  static constexpr std::size_t kPiece = 64, kLargest = std::size_t(1) << 25;
  std::mutex mutex_;
  std::shared_ptr<std::byte> block_;
  std::byte* at_ = nullptr;
  std::size_t left_ = 0, next_ = std::size_t(1) << 16;
};

}  // namespace fastlines
