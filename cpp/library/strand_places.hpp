// Where lines are along their strands: as Python's query/proximity/strand_places.py has it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fastlines/api/ray.hpp"

namespace fl::detail {

struct StrandPlaces {
  /// The number of a line's strand, or −1, and its position there.
  struct Place {
    std::int32_t strand = -1, position = -1;
  };
  std::vector<Place> places;          ///< of each line; empty if none has a strand
  std::vector<std::int32_t> periods;  ///< of each strand: how many lines it has if it is closed, or else 0
};

/// The places of lines; segments or round cones, the other is empty. A strand is closed if its last line ends where its
/// first one starts.
StrandPlaces strand_places(std::span<const std::int64_t> strand_of_line, std::span<const Segment> segments,
                           std::span<const RoundCone> cones);

}  // namespace fl::detail
