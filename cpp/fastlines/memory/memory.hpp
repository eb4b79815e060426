// Memory as large answers, the lists of a build and the blocks of a layout want it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace fastlines {

/// Memory as it is given out: aligned data after a header.
class Memory {
 public:
  /// In huge pages where that saves faults; a block that was released before if one is not much too large.
  static void* allocate(std::size_t n_bytes) {
    const std::size_t size = size_for(n_bytes);
    if (void* const again = kept().take(n_bytes, size)) return again;
    auto* const begin = static_cast<std::byte*>(std::aligned_alloc(alignment_for(n_bytes), kBlock + size));
    if (!begin) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    if (alignment_for(n_bytes) == kHuge)
      madvise(begin, kBlock + n_bytes, MADV_HUGEPAGE);  // a hint: if it is refused, nothing is lost
#endif
    new (begin) Header{size, size};
    return begin + kBlock;
  }

  /// Only the first so many bytes are of use: the system may have the pages behind them, which stay part of the block.
  static void use_first([[maybe_unused]] void* data, [[maybe_unused]] std::size_t n_bytes) noexcept {
#ifdef __linux__
    constexpr std::size_t page = 1 << 12, worth_it = 1 << 20;
    const auto begin = reinterpret_cast<std::uintptr_t>(data);
    const auto from = (begin + n_bytes + page - 1) / page * page, to = (begin + size_of(data)) / page * page;
    if (to <= from || to - from < worth_it) return;
    madvise(reinterpret_cast<void*>(from), to - from, MADV_DONTNEED);
    header_of(data).n_used = from - begin;
#endif
  }

  static void release(void* data) noexcept {
    if (data && !kept().keep(data)) std::free(begin_of(data));
  }

 private:
  struct Header {
    std::size_t size, n_used;  // bytes; no others than those in use are known to take memory
  };
  static constexpr std::size_t kBlock = 128, kHuge = std::size_t(1) << 21;

  static std::size_t alignment_for(std::size_t n_bytes) { return n_bytes >= 2 * kHuge ? kHuge : kBlock; }

  /// What a new block for so many bytes has room for.
  static std::size_t size_for(std::size_t n_bytes) {
    const std::size_t alignment = alignment_for(n_bytes);
    return (kBlock + n_bytes + alignment - 1) / alignment * alignment - kBlock;
  }

  static std::byte* begin_of(void* data) { return static_cast<std::byte*>(data) - kBlock; }
  static Header& header_of(void* data) { return *std::launder(reinterpret_cast<Header*>(begin_of(data))); }
  static std::size_t size_of(void* data) { return header_of(data).size; }

  /// What was released last: to touch memory of the system's for the first time takes longer than to write an answer
  /// to it, so the next answer takes that of an earlier one. Nobody waits for it: a process that was forked while it
  /// was in use would wait for ever.
  class Kept {
   public:
    /// A block for so many bytes that is not much larger than a new one would be.
    void* take(std::size_t n_bytes, std::size_t size_of_new) {
      if (n_bytes < kLeast) return nullptr;
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return nullptr;
      auto best = blocks_.end();
      for (auto block = blocks_.begin(); block != blocks_.end(); ++block) {
        const std::size_t size = size_of(*block);
        if (size >= n_bytes && size - size / 4 <= size_of_new && (best == blocks_.end() || size < size_of(*best)))
          best = block;
      }
      if (best == blocks_.end()) return nullptr;
      void* const data = *best;
      n_bytes_ -= std::exchange(header_of(data).n_used, size_of(data));
      blocks_.erase(best);
      return data;
    }

    /// Makes room by letting go of what was released first; false if the block is not worth keeping.
    bool keep(void* data) noexcept {
      const auto [size, n_used] = header_of(data);
      if (size < kLeast || n_used > kMost) return false;
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return false;
      while (n_bytes_ + n_used > kMost || blocks_.size() == kMostBlocks) {
        n_bytes_ -= header_of(blocks_.front()).n_used;
        std::free(begin_of(blocks_.front()));
        blocks_.erase(blocks_.begin());
      }
      blocks_.push_back(data);
      n_bytes_ += n_used;
      return true;
    }

   private:
    static constexpr std::size_t kLeast = std::size_t(1) << 16, kMost = std::size_t(1) << 28, kMostBlocks = 256;
    std::mutex mutex_;
    std::vector<void*> blocks_;
    std::size_t n_bytes_ = 0;                 // in use
    Kept() { blocks_.reserve(kMostBlocks); }  // so that keep never allocates
    friend class Memory;
  };

  /// Never destroyed: answers may outlive all else at exit.
  static Kept& kept() {
    static Kept& blocks = *new Kept;
    return blocks;
  }
};

/// A vector in such memory.
template <class T>
struct Allocator {
  using value_type = T;
  Allocator() = default;
  template <class Other>
  Allocator(const Allocator<Other>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(Memory::allocate(n * sizeof(T))); }
  void deallocate(T* data, std::size_t) noexcept { Memory::release(data); }
  bool operator==(const Allocator&) const { return true; }
};

template <class T>
using LargeVector = std::vector<T, Allocator<T>>;

/// Have room for so many more. Room that is not used costs only addresses, and to grow is to copy: so a small vector
/// grows by more than it would by itself.
template <class T>
void make_room_in(LargeVector<T>& vector, std::size_t n) {
  constexpr std::size_t small = std::size_t(1) << 21;
  if (const std::size_t size = vector.size() + n; size > vector.capacity())
    vector.reserve(size * (size * sizeof(T) < small ? 8 : 2));
}

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
      block_.reset(static_cast<std::byte*>(Memory::allocate(n_bytes)), &Memory::release);
      at_ = block_.get();
      left_ = n_bytes;
      next_ = std::min(2 * next_, kLargest);
    }
    return {block_, at_};
  }

  /// So much of the piece that was begun last is kept.
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
