// An uninitialised array of trivial types, for data that builds and queries write again and again.
#pragma once

#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "large_vector.hpp"

namespace fastlines {

/// Reserved elements are not touched. So a build can reserve more than it needs: pages that it does not write to cost
/// no memory.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;

  Buffer() = default;
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer(std::move(other)).swap(*this);
    return *this;
  }
  ~Buffer() {
    if (owns_) PagePool::release(data_);
  }

  /// A buffer in memory that another one owns. If more is reserved, it takes memory of its own.
  static Buffer within(std::span<T> room) {
    Buffer buffer;
    buffer.data_ = room.data();
    buffer.capacity_ = room.size();
    buffer.owns_ = false;
    return buffer;
  }

  /// Discards the contents and reserves n elements. Returns where to write them.
  T* reset(std::size_t n) {
    size_ = 0;
    if (n <= capacity_) return data_;
    *this = Buffer();
    data_ = static_cast<T*>(PagePool::allocate(n * sizeof(T)));
    capacity_ = n;
    return data_;
  }

  /// Reserves n elements and copies the first n_first.
  void grow(std::size_t n, std::size_t n_first) {
    Buffer larger;
    std::uninitialized_copy_n(data_, n_first, larger.reset(n));
    *this = std::move(larger);
  }

  /// Sets the size to n, at most the capacity. The caller writes the elements, before or after.
  void set_size(std::size_t n) { size_ = n; }

  void assign(std::span<const T> from) {
    std::uninitialized_copy(from.begin(), from.end(), reset(from.size()));
    size_ = from.size();
  }

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  operator std::span<const T>() const { return {data_, size_}; }

 private:
  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    std::swap(owns_, other.owns_);
  }

  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
  bool owns_ = true;
};

}  // namespace fastlines
