// What compiled shading takes from Python: rows of arrays, 16 at a time, the sky, and the tables of hair.
#pragma once

#include <cstring>

#include "arrays.hpp"
#include "fastlines/shading/hair_table.hpp"
#include "fastlines/shading/lights.hpp"
#include "gil.hpp"

namespace fastlines {

/// Calls group(first, n) for each 16 of n_rows rows, or fewer at the end, without the GIL.
template <class Group>
void in_lanes(std::size_t n_rows, Group&& group) {
  const WithoutGil without_gil;
  for (std::size_t first = 0; first < n_rows; first += kLanes)
    group(first, int(std::min<std::size_t>(kLanes, n_rows - first)));
}

using SkyNumbers = std::array<float, 12>;

inline SkyLight sky_of(const SkyNumbers& numbers) {
  SkyLight sky;
  static_assert(sizeof sky == sizeof numbers);
  std::memcpy(&sky, numbers.data(), sizeof sky);
  return sky;
}

/// `azimuths` is (rows, columns, HairTable::kValues), and `inclinations` is (rows, HairTable::kRest).
inline HairTable table_of(const HairMaterial& material, const Input<float>& azimuths,
                          const Input<float>& inclinations) {
  return {material, azimuths.data(), inclinations.data(), int(azimuths.shape(0)), int(azimuths.shape(1))};
}

}  // namespace fastlines
