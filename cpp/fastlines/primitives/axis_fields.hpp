// The fields of segments and round cones: the numbers that their exact tests read, in the frame of the scene.
#pragma once

#include <array>

namespace fastlines {

/// The start of a segment and end − start. `floats` is the segment as the caller gave it.
template <class N, class Frame>
[[gnu::always_inline]] inline std::array<N, 6> segment_fields(const N (&floats)[6], const Frame& frame) {
  std::array<N, 6> fields;
  for (int k = 0; k < 3; ++k) {
    const N centre = frame.centre[k], scale = frame.scale;
    fields[k] = (floats[k] - centre) * scale;
    fields[3 + k] = (floats[3 + k] - centre) * scale - fields[k];
  }
  return fields;
}

/// Those of the axis, the radius at its start, and the difference of the radii.
template <class N, class Frame>
[[gnu::always_inline]] inline std::array<N, 8> round_cone_fields(const N (&floats)[8], const Frame& frame) {
  const N ends[6] = {floats[0], floats[1], floats[2], floats[3], floats[4], floats[5]};
  const std::array<N, 6> axis = segment_fields(ends, frame);
  const N radius0 = floats[6] * N(frame.scale);
  return {axis[0], axis[1], axis[2], axis[3], axis[4], axis[5], radius0, floats[7] * N(frame.scale) - radius0};
}

}  // namespace fastlines
