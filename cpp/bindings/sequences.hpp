// Sequences of Python as arguments.
//
// nanobind converts arguments in functions that are noexcept. So an argument of the type std::vector ends the process
// if there is no memory for it. Functions take a Sequence instead, and make the vector where they may throw.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

namespace fastlines {

template <class T>
using Sequence = nanobind::typed<nanobind::sequence, T>;

/// The elements of a sequence. Arrays among them that are not contiguous are copied, and the vector owns the copies.
template <class T>
std::vector<T> vector_of(const Sequence<T>& from) {
  std::vector<T> made;
  made.reserve(nanobind::len(from));
  for (const nanobind::handle item : from) made.push_back(nanobind::cast<T>(item));
  return made;
}

}  // namespace fastlines
