// Memory in pieces of large blocks.
#pragma once

#include "page_pool.hpp"

namespace fastlines {

/// Gives out memory in pieces of large blocks, to one thread. A block lives as long as any piece of it; the last one
/// also as long as the arena, which begins it anew when no piece is left.
class Arena {
 public:
  Arena() = default;
  Arena(const Arena&) {}  // which has its own blocks
  Arena& operator=(const Arena&) = delete;

  /// A piece, which may be written to until the end of so many bytes.
  std::shared_ptr<std::byte> begin(std::size_t most_bytes) {
    if (block_.use_count() == 1) {  // no piece is left: its memory is in the cache yet
      std::atomic_thread_fence(std::memory_order_acquire);
      (void)std::shared_ptr(block_);  // ThreadSanitizer knows no fences, but what copies do to the count
      left_ += std::size_t(at_ - block_.get());
      at_ = block_.get();
    }
    if (left_ < most_bytes) {
      const std::size_t n_bytes = std::max(most_bytes, next_);
      block_.reset(static_cast<std::byte*>(PagePool::allocate(n_bytes)), &PagePool::release);
      at_ = block_.get();
      left_ = n_bytes;
      next_ = std::min(2 * next_, kLargest);
    }
    return {block_, at_};
  }

  /// So much of the piece that was begun last is free_list.
  void end(std::size_t n_bytes) {
    at_ += n_bytes;
    left_ -= n_bytes;
  }

 private:
  static constexpr std::size_t kLargest = std::size_t(1) << 23;
  std::shared_ptr<std::byte> block_;
  std::byte* at_ = nullptr;
  std::size_t left_ = 0, next_ = std::size_t(1) << 16;
};

}  // namespace fastlines
