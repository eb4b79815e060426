// Memory for large answers, the lists of a build and the blocks of a layout: aligned, in huge pages, and reused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#ifdef _WIN32
#include <malloc.h>
#elif __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace fastlines {

/// Allocates aligned blocks of data behind a header.
class PagePool {
 public:
  /// Returns a released block if one fits without much waste, otherwise a new one. Large blocks use huge pages, which
  /// saves page faults. Throws std::bad_alloc.
  static void* allocate(std::size_t n_bytes) {
    const std::size_t size = size_for(n_bytes);
    if (void* const again = free_list().pop(n_bytes, size)) return again;
    auto* const begin = static_cast<std::byte*>(allocate_aligned(alignment_for(n_bytes), kHeaderBytes + size));
    if (!begin) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    if (alignment_for(n_bytes) == kHugePage)
      madvise(begin, kHeaderBytes + n_bytes, MADV_HUGEPAGE);  // a hint: its failure does no harm
#endif
    new (begin) Header{size, size};
    return begin + kHeaderBytes;
  }

  /// Returns the pages past the first n_bytes to the system. Their addresses stay part of the block.
  static void trim([[maybe_unused]] void* data, [[maybe_unused]] std::size_t n_bytes) noexcept {
#ifdef __linux__
    constexpr std::size_t page = 1 << 12, min_bytes = 1 << 20;  // fewer bytes are not worth the call
    const auto begin = reinterpret_cast<std::uintptr_t>(data);
    const auto from = (begin + n_bytes + page - 1) / page * page, to = (begin + size_of(data)) / page * page;
    if (to <= from || to - from < min_bytes) return;
    // Fails where pages are larger than assumed: then the block stays as it is.
    if (madvise(reinterpret_cast<void*>(from), to - from, MADV_DONTNEED) == 0) header_of(data).n_used = from - begin;
#endif
  }

  /// Returns the whole huge pages between two addresses of one block to the system. They stay part of the block.
  static void discard([[maybe_unused]] const void* begin, [[maybe_unused]] const void* end) noexcept {
#ifdef __linux__
    const auto first = (reinterpret_cast<std::uintptr_t>(begin) + kHugePage - 1) / kHugePage * kHugePage,
               last = reinterpret_cast<std::uintptr_t>(end) / kHugePage * kHugePage;
    if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
#endif
  }

  /// Frees the blocks released first, until those kept occupy at most max_bytes.
  static void shrink(std::size_t max_bytes) noexcept { free_list().shrink(max_bytes); }

  /// Keeps a block for reuse or frees it; `data` may be null.
  static void release(void* data) noexcept {
    if (data && !free_list().add(data)) free_aligned(begin_of(data));
  }

 private:
  // Windows has no std::aligned_alloc, and its aligned memory has a function of its own to free it.
#ifdef _WIN32
  static void* allocate_aligned(std::size_t alignment, std::size_t size) { return _aligned_malloc(size, alignment); }
  static void free_aligned(void* begin) noexcept { _aligned_free(begin); }
#else
  static void* allocate_aligned(std::size_t alignment, std::size_t size) { return std::aligned_alloc(alignment, size); }
  static void free_aligned(void* begin) noexcept { std::free(begin); }
#endif

  struct Header {
    std::size_t size, n_used;  // bytes of the data, and of its part that may occupy memory
  };
  /// Bytes of a header, which is as large as the smallest alignment, and of a huge page.
  static constexpr std::size_t kHeaderBytes = 128, kHugePage = std::size_t(1) << 21;

  static std::size_t alignment_for(std::size_t n_bytes) { return n_bytes >= 2 * kHugePage ? kHugePage : kHeaderBytes; }

  /// The size of a new block for n_bytes: the whole block is a multiple of its alignment.
  static std::size_t size_for(std::size_t n_bytes) {
    const std::size_t alignment = alignment_for(n_bytes);
    return (kHeaderBytes + n_bytes + alignment - 1) / alignment * alignment - kHeaderBytes;
  }

  static std::byte* begin_of(void* data) { return static_cast<std::byte*>(data) - kHeaderBytes; }
  static void* data_of(std::byte* begin) { return begin + kHeaderBytes; }
  static Header& header_of(void* data) { return *std::launder(reinterpret_cast<Header*>(begin_of(data))); }
  static std::size_t size_of(void* data) { return header_of(data).size; }

  /// The blocks released last, for reuse: the page faults of new memory take longer than writing an answer to it.
  /// Nothing ever waits for the list's lock: in a process forked while a thread held the lock, that would take forever.
  class FreeList {
   public:
    /// The smallest block of at least n_bytes that is at most a third larger than a new one; null if there is none.
    void* pop(std::size_t n_bytes, std::size_t size_of_new) {
      if (n_bytes < kMinBytes) return nullptr;
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return nullptr;
      auto best = blocks_.end();
      for (auto block = blocks_.begin(); block != blocks_.end(); ++block) {
        const std::size_t size = size_of(data_of(*block));
        if (size >= n_bytes && size - size / 4 <= size_of_new &&
            (best == blocks_.end() || size < size_of(data_of(*best))))
          best = block;
      }
      if (best == blocks_.end()) return nullptr;
      void* const data = data_of(*best);
      n_bytes_ -= std::exchange(header_of(data).n_used, size_of(data));
      blocks_.erase(best);
      return data;
    }

    /// Keeps a block and frees the oldest ones to make room. Returns false if the block is too small or too large to
    /// keep, or if the lock is taken.
    bool add(void* data) noexcept {
      const auto [size, n_used] = header_of(data);
      if (size < kMinBytes || n_used > kMaxBytes) return false;
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return false;
      while (n_bytes_ + n_used > kMaxBytes || blocks_.size() == kMaxBlocks) free_oldest();
      blocks_.push_back(begin_of(data));
      n_bytes_ += n_used;
      return true;
    }

    /// Frees the oldest blocks, until the others occupy at most max_bytes.
    void shrink(std::size_t max_bytes) noexcept {
      const std::unique_lock lock(mutex_, std::try_to_lock);
      while (lock && n_bytes_ > max_bytes) free_oldest();
    }

    /// Frees all blocks.
    void clear() noexcept {
      const std::unique_lock lock(mutex_, std::try_to_lock);
      while (lock && !blocks_.empty()) free_oldest();
    }

   private:
    void free_oldest() noexcept {
      n_bytes_ -= header_of(data_of(blocks_.front())).n_used;
      free_aligned(blocks_.front());
      blocks_.erase(blocks_.begin());
    }

    /// Bytes of the smallest block to keep; the most bytes and the most blocks kept.
    static constexpr std::size_t kMinBytes = std::size_t(1) << 16, kMaxBytes = std::size_t(1) << 28, kMaxBlocks = 256;
    std::mutex mutex_;
    std::vector<std::byte*> blocks_;             // where they begin, oldest first
    std::size_t n_bytes_ = 0;                    // the sum of their n_used
    FreeList() { blocks_.reserve(kMaxBlocks); }  // so that `add` never allocates
    friend class PagePool;
  };

  /// The list is never destroyed, as answers may outlive every static object. At exit its blocks are freed.
  static FreeList& free_list() {
    static FreeList& blocks = *new FreeList;
    static const struct AtExit {
      ~AtExit() { blocks.clear(); }
    } at_exit;
    return blocks;
  }
};

}  // namespace fastlines
