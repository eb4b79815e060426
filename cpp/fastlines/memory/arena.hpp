// A bump allocator: allocations are parts of large blocks. A block is freed with the last of its parts.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>

#include "page_pool.hpp"

namespace fastlines {

/// Allocates memory for one thread. A block lives as long as any allocation in it. The current block also lives as long
/// as the arena, which reuses it from the start once no allocation in it is left.
class Arena {
 public:
  Arena() = default;
  Arena(const Arena&) {}  // a copy starts without blocks
  Arena& operator=(const Arena&) = delete;

  /// Begins an allocation of up to max_bytes; `end` fixes its size.
  std::shared_ptr<std::byte> begin(std::size_t max_bytes) {
    // Reuse the block if no allocation in it is left: its memory is still in the cache.
    if (block_.use_count() == 1) {
      std::atomic_thread_fence(std::memory_order_acquire);
      (void)std::shared_ptr(block_);  // ThreadSanitizer ignores fences but understands the count of a copy
      left_ += std::size_t(at_ - block_.get());
      at_ = block_.get();
    }
    if (left_ < max_bytes) {
      const std::size_t n_bytes = std::max(max_bytes, next_);
      block_.reset(static_cast<std::byte*>(PagePool::allocate(n_bytes)), &PagePool::release);
      at_ = block_.get();
      left_ = n_bytes;
      next_ = std::min(2 * next_, kMaxBlockBytes);
    }
    return {block_, at_};
  }

  /// Ends the allocation begun last at n_bytes; the next one gets the rest.
  void end(std::size_t n_bytes) {
    at_ += n_bytes;
    left_ -= n_bytes;
  }

 private:
  /// Blocks double in size up to this; only a larger allocation gets a larger block.
  static constexpr std::size_t kMaxBlockBytes = std::size_t(1) << 23;
  std::shared_ptr<std::byte> block_;
  std::byte* at_ = nullptr;                             // start of the next allocation
  std::size_t left_ = 0, next_ = std::size_t(1) << 16;  // bytes left in the block; size of the next block
};

}  // namespace fastlines
