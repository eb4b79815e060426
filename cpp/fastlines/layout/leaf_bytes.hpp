// The order of the coordinates of a leaf's pieces in its 96 bytes.
#pragma once

namespace fastlines {

/// The index of the byte that holds a coordinate of an end (0 or 1) of a piece. Bytes are pairs: x and y of the first
/// ends, then z of both ends, then x and y of the second ends.
constexpr int end_byte(int end, int axis, int piece) {
  return axis < 2 ? 64 * end + 2 * piece + axis : 32 + 2 * piece + end;
}

}  // namespace fastlines
