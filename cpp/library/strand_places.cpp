// Numbers the lines of each strand.
#include "strand_places.hpp"

#include <algorithm>

namespace fl::detail {

std::vector<StrandPlace> strand_places(std::span<const std::int64_t> strand_of_line, std::span<const Segment> segments,
                                       std::span<const RoundCone> cones) {
  const auto ends = [&](std::size_t line) {
    return segments.empty() ? Segment{cones[line].p, cones[line].q} : segments[line];
  };
  std::vector<std::size_t> lines;  // by strand
  for (std::size_t line = 0; line < strand_of_line.size(); ++line)
    if (strand_of_line[line] >= 0) lines.push_back(line);
  const auto by_strand = [&](std::size_t a, std::size_t b) { return strand_of_line[a] < strand_of_line[b]; };
  if (!std::ranges::is_sorted(lines, by_strand)) std::ranges::stable_sort(lines, by_strand);

  std::vector<StrandPlace> found;
  if (lines.empty()) return found;
  found.resize(strand_of_line.size());
  std::int32_t strand = 0;
  for (std::size_t begin = 0, end; begin < lines.size(); begin = end, ++strand) {
    for (end = begin; end < lines.size() && strand_of_line[lines[end]] == strand_of_line[lines[begin]];) ++end;
    const Vec3 first = ends(lines[begin]).p, last = ends(lines[end - 1]).q;
    const bool is_closed = first.x == last.x && first.y == last.y && first.z == last.z;
    const std::int32_t period = is_closed ? std::int32_t(end - begin) : 0;
    for (std::size_t at = begin; at < end; ++at) found[lines[at]] = {strand, std::int32_t(at - begin), period};
  }
  return found;
}

}  // namespace fl::detail
