// The table behind `compress`: for each 8-bit mask, the indices of its set bits in ascending order.
#pragma once

#include <array>
#include <cstdint>

namespace fastlines {

struct CompressTable {
  std::uint8_t lanes[256][8] = {};

  constexpr CompressTable() {
    for (int bits = 0; bits < 256; ++bits)
      for (int lane = 0, n = 0; lane < 8; ++lane)
        if (bits >> lane & 1) lanes[bits][n++] = std::uint8_t(lane);
  }
};

inline constexpr CompressTable kCompressTable;

}  // namespace fastlines
