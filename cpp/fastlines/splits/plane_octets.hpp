// The planes of a regular grid over the node's box, eight at a time: what `PlaneGrid` shows, for straight pieces, in
// less time. In small nodes also splits into whole pieces, each on the side of its centre.
//
// Counts are exact; where a piece crosses a plane is computed in float32, so bounds may be off by some roundings, and
// whoever carries a split out takes the bounds of what comes of it.
#pragma once

#include "octet_grid.hpp"

namespace fastlines {

/// Curves that are straight from p to q.
template <class P>
concept Straight = Curves<P> && requires(const P& prims, std::uint32_t prim) {
  { prims.curve(prim) } -> std::same_as<const Segment&>;
};

class PlaneOctets {
 public:
  int n_planes = 16;
  std::size_t max_whole = 0;   ///< nodes of at most so many references are also split into whole ones; tight boxes only
  std::size_t only_whole = 0;  ///< and those of at most so many only so, where that divides them

  /// Show of each axis the split with the least SAH, for boxes grown by a margin; or all.
  template <Straight P, class Visitor>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, double margin, bool all,
             Visitor&& visitor) const {
    thread_local OctetGrid grid;
    const auto show = [&](Candidate::Kind kind) { return grid.show(kind, box, rule, float(margin), all, visitor); };
    if (rule == BoxRule::cut) {
      grid.place(box, n_planes, rule);
      for (const BuildRef& ref : refs) grid.count(ref.box);
      show(Candidate::Kind::plane);
      return;
    }
    if (refs.size() <= max_whole) {
      grid.place(box, n_planes, rule);
      for (const BuildRef& ref : refs) grid.add_whole(ref.box);
      const bool shown = show(Candidate::Kind::centres);
      if (shown && refs.size() <= only_whole) return;
    }
    grid.place(box, n_planes, rule);
    for (std::size_t i = 0; i < refs.size(); ++i) {
      if (i + 8 < refs.size()) __builtin_prefetch(&prims.curve(refs[i + 8].ref.prim));
      grid.add_piece(prims.curve(refs[i].ref.prim), refs[i].box);
    }
    show(Candidate::Kind::plane);
  }
};

}  // namespace fastlines
