// NumPy arrays as arguments and results. Python has checked their shapes, dtypes and values.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <type_traits>

#include "fastlines/math/box.hpp"
#include "fastlines/memory/page_pool.hpp"

namespace fastlines {

template <class Scalar>
using Input = nanobind::ndarray<const Scalar, nanobind::c_contig, nanobind::device::cpu>;

template <class Scalar>
using Output = nanobind::ndarray<nanobind::numpy, Scalar>;

/// The low and the high corner of a box.
using Corners = std::array<float, 6>;

inline Box box_of(const Corners& corners) {
  return {{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
}

/// The rows of an array, viewed as structs.
template <class Row, class Scalar>
std::span<const Row> rows(const Input<Scalar>& array) {
  return {reinterpret_cast<const Row*>(array.data()), array.size() * sizeof(Scalar) / sizeof(Row)};
}

/// An uninitialised array of n rows of `width` values that owns its memory; width 0 makes it one-dimensional.
template <class Scalar>
Output<Scalar> make_array(std::size_t n, std::size_t width = 0) {
  void* const data = PagePool::allocate(n * std::max<std::size_t>(1, width) * sizeof(Scalar));
  nanobind::capsule owner(data, &PagePool::release);
  const std::size_t shape[] = {n, width};
  return Output<Scalar>(static_cast<Scalar*>(data), width ? 2 : 1, shape, owner);
}

/// An array that takes over a LargeVector or Buffer without a copy. Structs become rows of scalars; a vector of scalars
/// becomes a one-dimensional array. Unused pages are returned to the system.
template <class Scalar, class Vector>
Output<Scalar> adopt(Vector&& from) {
  using Row = typename Vector::value_type;
  static_assert(!std::is_lvalue_reference_v<Vector> && sizeof(Row) % sizeof(Scalar) == 0);
  auto moved = std::make_unique<Vector>(std::move(from));
  nanobind::capsule owner(moved.get(), [](void* vector) noexcept { delete static_cast<Vector*>(vector); });
  Vector& rows = *moved.release();
  if (rows.data()) PagePool::trim(rows.data(), rows.size() * sizeof(Row));
  const std::size_t shape[] = {rows.size(), sizeof(Row) / sizeof(Scalar)};
  return Output<Scalar>(reinterpret_cast<Scalar*>(rows.data()), sizeof(Row) == sizeof(Scalar) ? 1 : 2, shape, owner);
}

}  // namespace fastlines
