// The planes of a regular grid over the node's box, eight at a time: what `PlaneGrid` shows, for straight pieces, in
// less time. In small nodes also splits into whole pieces, each on the side of its centre, and in larger ones where
// these lie well apart; in large ones a plane that is good for a sample is good for all.
//
// Counts are exact; where a piece crosses a plane is computed in float32, so bounds may be off by some roundings, and
// those of a sample are no more than the sample's. Whoever carries a split out takes the bounds of what comes of it.
#pragma once

#include <optional>

#include "bins_x8.hpp"
#include "overlap.hpp"

namespace fastlines {

class BinnedPlanes {
 public:
  int n_planes = 16;
  std::size_t uncut_up_to =
      0;  ///< nodes of at most so many references are also split into whole ones; tight boxes only
  std::size_t only_uncut_up_to = 0;  ///< and those of at most so many only so, where that divides them
  double max_overlap = 0.0;   ///< or where the children of the best whole split overlap in no more of the node's area
  std::size_t sample = 0;     ///< of at least twice so many, about so many are asked, if one is to be shown; if 0, all
  std::size_t gap_up_to = 0;  ///< larger nodes, of up to so many, only so where they lie apart; not if all are shown
  double gap_cost = 0.8;      ///< where that costs no more than this share of a leaf

  /// Show of each axis the split with the least SAH, as it is measured; or all.
  template <Straight P, class Visitor>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, const Measure& measure, bool all,
             Visitor&& visitor) const {
    thread_local BinsX8 grid;
    if (!all) {
      // Lanes say nothing of a sample, and next to nothing of as many as are split here.
      if (const auto split = split_of_large(prims, refs, box, rule, {measure.margin}, grid)) return visitor(*split);
    }
    if (rule == BoxRule::tight && refs.size() <= uncut_up_to) {
      fill_whole(refs, box, grid);
      Overlap overlap;
      const bool shown = grid.show(Candidate::Kind::centres, box, rule, measure, all, [&](const Candidate& split) {
        overlap.look_at(split, measure);
        visitor(split);
      });
      const bool apart = max_overlap > 0.0 && overlap.area() <= max_overlap * measure.area(box);
      if (shown && (refs.size() <= only_uncut_up_to || apart)) return;
    }
    fill(prims, refs, box, rule, grid);
    grid.show(Candidate::Kind::plane, box, rule, measure, all, visitor);
  }

 private:
  void fill_whole(Refs refs, const Box& box, BinsX8& grid) const {
    grid.place(box, n_planes, BoxRule::tight);
    for (const BuildRef& ref : refs) grid.add_whole(ref.box);
  }

  template <Straight P>
  void fill(const P& prims, Refs refs, const Box& box, BoxRule rule, BinsX8& grid) const {
    grid.place(box, n_planes, rule);
    for (std::size_t i = 0; i < refs.size(); ++i) {
      if (rule == BoxRule::cut) {
        grid.count(refs[i].box);
      } else {
        if (i + 8 < refs.size()) prefetch(prims, refs[i + 8].ref.prim);
        grid.add_piece(prims.curve(refs[i].ref.prim), refs[i].box);
      }
    }
  }

  /// One split of a large node: into whole references where these lie apart, or the plane that is best for a sample.
  /// What a sample has chosen is looked at in full.
  template <Straight P>
  std::optional<Candidate> split_of_large(const P& prims, Refs refs, const Box& box, BoxRule rule,
                                          const Measure& measure, BinsX8& grid) const {
    const bool may_be_apart = rule == BoxRule::tight && refs.size() > uncut_up_to && refs.size() <= gap_up_to,
               sampled = sample > 0 && refs.size() / 2 >= sample;
    if (!sampled) return may_be_apart ? whole_if_apart(refs, refs, box, measure, grid) : std::nullopt;
    constexpr std::size_t kMostKept = 1 << 14;
    thread_local std::vector<BuildRef> some;
    some.clear();
    for (std::size_t i = 0, step = refs.size() / sample; i < refs.size(); i += step) some.push_back(refs[i]);
    std::optional<Candidate> split;
    if (may_be_apart) split = whole_if_apart(refs, some, box, measure, grid);
    if (!split) {
      fill(prims, some, box, rule, grid);
      split = cheapest(Candidate::Kind::plane, box, rule, measure, grid);
      if (split) count(refs, *split);
    }
    if (some.capacity() > kMostKept) some = {};
    return split && divides(*split, rule) ? split : std::nullopt;
  }

  /// Into whole references: the split that is best for some of them, if it parts all well.
  std::optional<Candidate> whole_if_apart(Refs refs, Refs some, const Box& box, const Measure& measure,
                                          BinsX8& grid) const {
    fill_whole(some, box, grid);
    auto split = cheapest(Candidate::Kind::centres, box, BoxRule::tight, measure, grid);
    if (split && some.size() < refs.size()) look_at_whole(refs, *split);
    if (split && split->sah(measure) > gap_cost * measure.area(box) * measure.tests(refs.size())) split.reset();
    return split;
  }

  static void look_at_whole(Refs refs, Candidate& split) {
    BoxX4 bounds[2] = {BoxX4::empty(), BoxX4::empty()};
    split.n_left = 0;
    for (const BuildRef& ref : refs) {
      const unsigned on_left = centre_of(ref.box, split.axis) < split.plane;  // which can not be foreseen
      split.n_left += on_left;
      bounds[on_left].grow(BoxX4::load(ref.box));
    }
    split.n_right = refs.size() - split.n_left;
    split.left = bounds[1].box();
    split.right = bounds[0].box();
  }

  static void count(Refs refs, Candidate& split) {
    split.n_left = split.n_right = 0;
    for (const BuildRef& ref : refs) {
      const auto side = unsigned(side_of(ref.box, split.axis, split.plane));
      split.n_left += side & 1;
      split.n_right += side >> 1;
    }
  }

  static std::optional<Candidate> cheapest(Candidate::Kind kind, const Box& box, BoxRule rule, const Measure& measure,
                                           BinsX8& grid) {
    double least = std::numeric_limits<double>::infinity();
    std::optional<Candidate> best;
    grid.show(kind, box, rule, measure, false, [&](const Candidate& split) {
      const double sah = split.sah(measure);
      if (!(sah < least)) return;
      least = sah;
      best = split;
    });
    return best;
  }
};

}  // namespace fastlines
