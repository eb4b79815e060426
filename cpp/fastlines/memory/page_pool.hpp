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
class PagePool {
 public:
  /// In huge pages where that saves faults; a block that was released before if one is not much too large.
  static void* allocate(std::size_t n_bytes) {
    const std::size_t size = size_for(n_bytes);
    if (void* const again = free_list().take(n_bytes, size)) return again;
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
    if (data && !free_list().add(data)) std::free(begin_of(data));
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
  class FreeList {
   public:
    /// A block for so many bytes that is not much larger than a new one would be.
    void* take(std::size_t n_bytes, std::size_t size_of_new) {
      if (n_bytes < kMinBytes) return nullptr;
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
    bool add(void* data) noexcept {
      const auto [size, n_used] = header_of(data);
      if (size < kMinBytes || n_used > kMaxBytes) return false;
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return false;
      while (n_bytes_ + n_used > kMaxBytes || blocks_.size() == kMaxBlocks) {
        n_bytes_ -= header_of(blocks_.front()).n_used;
        std::free(begin_of(blocks_.front()));
        blocks_.erase(blocks_.begin());
      }
      blocks_.push_back(data);
      n_bytes_ += n_used;
      return true;
    }

   private:
    static constexpr std::size_t kMinBytes = std::size_t(1) << 16, kMaxBytes = std::size_t(1) << 28, kMaxBlocks = 256;
    std::mutex mutex_;
    std::vector<void*> blocks_;
    std::size_t n_bytes_ = 0;                    // in use
    FreeList() { blocks_.reserve(kMaxBlocks); }  // so that keep never allocates
    friend class PagePool;
  };

  /// Never destroyed: answers may outlive all else at exit.
  static FreeList& free_list() {
    static FreeList& blocks = *new FreeList;
    return blocks;
  }
};

}  // namespace fastlines
