// An uninitialised array of trivial types, for data that builds and queries write again and again.
#pragma once

#include <span>
#include <type_traits>
#include <utility>

#include "large_vector.hpp"

namespace fastlines {

/// An uninitialised array. A build reserves more elements than it keeps, and pages that it does not write to are never
/// touched.
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
  ~Buffer() { PagePool::release(data_); }

  /// Discards the contents and reserves n elements.
  T* make_room(std::size_t n) {
    size_ = 0;
    if (n <= capacity_) return data_;
    *this = Buffer();
    data_ = static_cast<T*>(PagePool::allocate(n * sizeof(T)));
    capacity_ = n;
    return data_;
  }

  /// Reserves n elements and keeps the first n_first.
  void grow(std::size_t n, std::size_t n_first) {
    Buffer larger;
    std::uninitialized_copy_n(data_, n_first, larger.make_room(n));
    *this = std::move(larger);
  }

  /// Sets the size to n; the first n elements have been or will be written by the caller.
  void keep(std::size_t n) { size_ = n; }

  void assign(std::span<const T> from) {
    std::uninitialized_copy(from.begin(), from.end(), make_room(from.size()));
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
  }

  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace fastlines
