// NumPy arrays in and out. Python has checked shapes, dtypes and values; here they are only looked at as plain data.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "fastlines/query/memory.hpp"

namespace fastlines {

template <class Scalar>
using Input = nanobind::ndarray<const Scalar, nanobind::c_contig, nanobind::device::cpu>;

template <class Scalar>
using Output = nanobind::ndarray<nanobind::numpy, Scalar>;

/// The rows of an array as structs of the same bytes.
template <class Row, class Scalar>
std::span<const Row> rows(const Input<Scalar>& array) {
  return {reinterpret_cast<const Row*>(array.data()), array.size() * sizeof(Scalar) / sizeof(Row)};
}

/// An array of `n` rows of `width` numbers that owns its memory; width 0 gives one dimension.
template <class Scalar>
Output<Scalar> make_array(std::size_t n, std::size_t width = 0) {
  void* const data = Memory::allocate(n * std::max<std::size_t>(1, width) * sizeof(Scalar));
  nanobind::capsule owner(data, &Memory::release);
  const std::size_t shape[] = {n, width};
  return Output<Scalar>(static_cast<Scalar*>(data), width ? 2 : 1, shape, owner);
}

/// A copy of a vector of structs as rows of numbers.
template <class Scalar, class Row>
Output<Scalar> copy_rows(const std::vector<Row>& from) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0);
  auto array = make_array<Scalar>(from.size(), sizeof(Row) / sizeof(Scalar));
  std::memcpy(array.data(), from.data(), from.size() * sizeof(Row));
  return array;
}

/// A vector of numbers as an array, which has it from now on.
template <class Scalar>
Output<Scalar> adopt_column(LargeVector<Scalar>&& from) {
  auto kept = std::make_unique<LargeVector<Scalar>>(std::move(from));
  nanobind::capsule owner(kept.get(), [](void* vector) noexcept { delete static_cast<LargeVector<Scalar>*>(vector); });
  LargeVector<Scalar>& column = *kept.release();
  const std::size_t shape[] = {column.size()};
  return Output<Scalar>(column.data(), 1, shape, owner);
}

}  // namespace fastlines
