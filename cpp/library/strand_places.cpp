// Numbers the lines of each strand.
#include "strand_places.hpp"

#include <algorithm>

namespace fl::detail {

StrandPlaces strand_places(std::span<const std::int64_t> strand_of_line, std::span<const Segment> segments,
                           std::span<const RoundCone> cones) {
  const auto ends = [&](std::size_t line) {
    return segments.empty() ? Segment{cones[line].p, cones[line].q} : segments[line];
  };
  std::vector<std::size_t> lines;  // by strand
  for (std::size_t line = 0; line < strand_of_line.size(); ++line)
    if (strand_of_line[line] >= 0) lines.push_back(line);
  const auto by_strand = [&](std::size_t a, std::size_t b) { return strand_of_line[a] < strand_of_line[b]; };
  if (!std::ranges::is_sorted(lines, by_strand)) std::ranges::stable_sort(lines, by_strand);

  StrandPlaces found;
  if (lines.empty()) return found;
  found.places.resize(strand_of_line.size());
  for (std::size_t begin = 0, end; begin < lines.size(); begin = end) {
    const auto strand = std::int32_t(found.periods.size());
    for (end = begin; end < lines.size() && strand_of_line[lines[end]] == strand_of_line[lines[begin]]; ++end)
      found.places[lines[end]] = {strand, std::int32_t(end - begin)};
    const Vec3 first = ends(lines[begin]).p, last = ends(lines[end - 1]).q;
    const bool is_closed = first.x == last.x && first.y == last.y && first.z == last.z;
    found.periods.push_back(is_closed ? std::int32_t(end - begin) : 0);
  }
  return found;
}

}  // namespace fl::detail
