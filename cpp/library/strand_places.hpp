// Where lines are along their strands: as Python's query/proximity/strand_places.py has it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fastlines/api/ray.hpp"

namespace fl::detail {

struct StrandPlace {
  /// The number of a line's strand, or −1; its position there; and how many lines the strand has if it is closed, or 0.
  std::int32_t strand = -1, position = -1, period = 0;
};

/// The places of lines; segments or round cones, the other is empty. Empty if no line has a strand. A strand is closed
/// if its last line ends where its first one starts.
std::vector<StrandPlace> strand_places(std::span<const std::int64_t> strand_of_line, std::span<const Segment> segments,
                                       std::span<const RoundCone> cones);

}  // namespace fl::detail
