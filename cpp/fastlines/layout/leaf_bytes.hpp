// Where the coordinates of a leaf's pieces stand among its bytes.
#pragma once

namespace fastlines {

/// Of a leaf's 96 bytes, that of a coordinate of one end of a piece: x and y of the first ends stand in pairs, then z
/// of both ends, then x and y of the second ends.
constexpr int end_byte(int end, int axis, int piece) {
  return axis < 2 ? 64 * end + 2 * piece + axis : 32 + 2 * piece + end;
}

}  // namespace fastlines
