// The axes of a set of primitives, with their radii: all that pairs read of segments, round cones and shapes. So pairs
// of any two of these kinds are compiled once.
#pragma once

#include <cstdint>
#include <span>

#include "../../primitives/shapes.hpp"
#include "../../rays/frame.hpp"
#include "../../simd/transpose.hpp"

namespace fastlines {

/// The fields of an axis that the test of a pair reads: both ends, and the radius at each.
inline constexpr int kAxisFields = 8;

/// Primitives whose items begin with the ends of an axis, followed by its radii, if there are any.
struct AxisSet {
  const float* floats = nullptr;
  std::size_t stride = 0;  ///< floats of an item
  std::size_t n_rows = 0;
  bool has_radius = false;
  bool lists_whole = false;             ///< whether leaves list whole primitives, not pieces of axes
  std::span<const std::int64_t> owner;  ///< the primitive of each row, rising; empty if each row is one

  const float* row(std::uint32_t i) const { return floats + i * stride; }
  std::int64_t owner_of(std::uint32_t i) const { return owner.empty() ? std::int64_t(i) : owner[i]; }
  std::size_t n_prims() const { return owner.empty() ? n_rows : std::size_t(owner.back()) + 1; }

  /// The fields of one axis in the frame.
  template <bool surface>
  [[gnu::always_inline]] void load(std::uint32_t i, const Frame& frame, float (&fields)[kAxisFields]) const {
    std::memcpy(fields, row(i), (surface && has_radius ? kAxisFields : 6) * sizeof(float));
    to_frame<surface>(frame, fields);
  }

  /// Those of the 16 axes in these rows.
  template <bool surface>
  [[gnu::always_inline]] void load(const float* const (&rows)[kSimdWidth], const Frame& frame,
                                   FloatX16 (&fields)[kAxisFields]) const {
    if (surface && has_radius) {
      transpose_rows(rows, fields);
    } else {
      FloatX16 ends[6];
      transpose_rows(rows, ends);
      std::copy_n(ends, 6, fields);
    }
    to_frame<surface>(frame, fields);
  }

 private:
  template <bool surface, class N>
  [[gnu::always_inline]] void to_frame(const Frame& frame, N (&fields)[kAxisFields]) const {
    for (int k = 0; k < 6; ++k) fields[k] = (fields[k] - N(frame.centre[k % 3])) * N(frame.scale);
    for (int k = 6; k < kAxisFields; ++k) fields[k] = surface && has_radius ? fields[k] * N(frame.scale) : N(0.0f);
  }
};

/// The axes of primitives that all have one.
template <RayPrimitive P>
AxisSet axes_of(const P& prims, std::span<const std::int64_t> owner = {}) {
  static_assert(AxisPrimitive<P> || MixedPrimitive<P>);
  return {reinterpret_cast<const float*>(prims.items()),
          sizeof(typename P::Item) / sizeof(float),
          prims.size(),
          kHasRadius<P>,
          MixedPrimitive<P>,
          owner};
}

}  // namespace fastlines
