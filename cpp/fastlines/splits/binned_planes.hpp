// The planes of a regular grid over the node's box, 8 at a time: the candidates of `PlaneGrid`, for straight pieces,
// evaluated in less time.
//
// Small nodes also get uncut splits, with each piece on the side of its centre, and so do larger nodes whose pieces lie
// apart. In large nodes, the best plane of a sample replaces the best of all references.
//
// Counts are exact. Crossings of pieces and planes are computed in float32, so boxes may be off by rounding, and those
// of a sample bound only the sample. The builder recomputes the boxes of the children when it applies such a split.
#pragma once

#include <optional>

#include "bins_x8.hpp"
#include "overlap.hpp"

namespace fastlines {

class BinnedPlanes {
 public:
  static constexpr bool kTightOnly = false;

  int n_planes = 16;  ///< on each axis

  /// Nodes of at most this many references are offered uncut splits as well as planes; tight boxes only.
  std::size_t uncut_refs = 0;
  /// Nodes of at most this many references are offered only uncut splits, if there are any.
  std::size_t uncut_only_refs = 0;
  /// So are nodes where the children of the best uncut split overlap by at most this fraction of the node's area; 0:
  /// none.
  double max_overlap = 0.0;
  /// Nodes of at least twice this many references choose a plane by a sample of about this many; 0: by all references.
  /// Only where the caller needs one split, not all of them.
  std::size_t sample = 0;
  /// Nodes of more than `uncut_refs` and at most this many references are split uncut where their references lie apart.
  /// Only where the caller needs one split, not all of them.
  std::size_t gap_refs = 0;
  /// References lie apart if an uncut split costs at most this fraction of the cost of a leaf.
  double gap = 0.8;
  /// Nodes whose longest side is less than this many margins of `measure` are offered only uncut splits, if there are
  /// any: where boxes hardly exceed a query's radius, smaller pieces save few tests. Tight boxes only.
  double uncut_only_side = 0.0;

  /// Pass the split with the least SAH of each axis to `visitor`, or all splits if `all`. SAH is that of `measure`.
  template <Straight P>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, const Measure& measure, bool all,
             CandidateVisitor visitor) const {
    thread_local BinsX8 grid;
    const bool small = rule == BoxRule::tight && box.side(box.longest_axis()) < uncut_only_side * measure.margin;
    if (!all && !small) {
      // Ignore the lanes: rounding up to full lanes means nothing for a sample, and little for nodes of this size.
      if (const auto split = split_of_large(prims, refs, box, rule, {measure.margin}, grid)) return visitor(*split);
    }
    // Offer uncut splits.
    if (rule == BoxRule::tight && (small || refs.size() <= uncut_refs)) {
      fill_uncut(refs, box, grid);
      Overlap overlap;
      const bool any_uncut = grid.visit(Candidate::Kind::centres, box, rule, measure, all, [&](const Candidate& split) {
        overlap.add(split, measure);
        visitor(split);
      });
      const bool apart = max_overlap > 0.0 && overlap.area() <= max_overlap * measure.area(box);
      if (any_uncut && (small || refs.size() <= uncut_only_refs || apart)) return;
    }
    // Offer planes.
    fill(prims, refs, box, rule, grid);
    grid.visit(Candidate::Kind::plane, box, rule, measure, all, visitor);
  }

  /// Pass the uncut split with the least SAH of each axis to `visitor`, for a node of any size, if small nodes have
  /// any; planes where all centres coincide.
  template <Straight P>
  void visit_uncut(const P& prims, Refs refs, const Box& box, const Measure& measure, CandidateVisitor visitor) const {
    constexpr std::size_t any = std::size_t(-1);
    if (uncut_refs > 0 || gap_refs > 0 || uncut_only_side > 0.0)
      BinnedPlanes{.n_planes = n_planes, .uncut_refs = any, .uncut_only_refs = any}.visit(
          prims, refs, box, BoxRule::tight, measure, false, visitor);
  }

 private:
  static constexpr std::size_t kPrefetchDistance = 8;     // references
  static constexpr std::size_t kMaxKeptSample = 1 << 14;  // references that a thread keeps memory for

  void fill_uncut(Refs refs, const Box& box, BinsX8& grid) const {
    grid.place(box, n_planes, BoxRule::tight);
    for (const BuildRef& ref : refs) grid.add_uncut(ref.box);
  }

  template <Straight P>
  void fill(const P& prims, Refs refs, const Box& box, BoxRule rule, BinsX8& grid) const {
    grid.place(box, n_planes, rule);
    for (std::size_t i = 0; i < refs.size(); ++i) {
      if (rule == BoxRule::cut) {
        grid.count(refs[i].box);
      } else {
        if (i + kPrefetchDistance < refs.size()) prefetch(prims, refs[i + kPrefetchDistance].ref.prim);
        grid.add_piece(prims.curve(refs[i].ref.prim), refs[i].box);
      }
    }
  }

  /// One split of a large node: an uncut one if the references lie apart, otherwise the best plane of a sample. A split
  /// that a sample has chosen is evaluated on all references. None for nodes to which neither applies.
  template <Straight P>
  std::optional<Candidate> split_of_large(const P& prims, Refs refs, const Box& box, BoxRule rule,
                                          const Measure& measure, BinsX8& grid) const {
    const bool may_be_apart = rule == BoxRule::tight && refs.size() > uncut_refs && refs.size() <= gap_refs,
               by_sample = sample > 0 && refs.size() / 2 >= sample;
    if (!by_sample) return may_be_apart ? uncut_if_apart(refs, refs, box, measure, grid) : std::nullopt;
    // Choose by a sample.
    thread_local std::vector<BuildRef> chosen;
    chosen.clear();
    for (std::size_t i = 0, step = refs.size() / sample; i < refs.size(); i += step) chosen.push_back(refs[i]);
    std::optional<Candidate> split;
    if (may_be_apart) split = uncut_if_apart(refs, chosen, box, measure, grid);
    if (!split) {
      fill(prims, chosen, box, rule, grid);
      split = cheapest(Candidate::Kind::plane, box, rule, measure, grid);
      if (split) count(refs, *split);
    }
    if (chosen.capacity() > kMaxKeptSample) chosen = {};
    return split && divides(*split, rule) ? split : std::nullopt;
  }

  /// The best uncut split of `sampled` references, if all references lie apart by it.
  std::optional<Candidate> uncut_if_apart(Refs refs, Refs sampled, const Box& box, const Measure& measure,
                                          BinsX8& grid) const {
    fill_uncut(sampled, box, grid);
    auto split = cheapest(Candidate::Kind::centres, box, BoxRule::tight, measure, grid);
    if (split && sampled.size() < refs.size()) evaluate_uncut(refs, *split);
    if (split && split->sah(measure) > gap * measure.area(box) * measure.tests(refs.size())) split.reset();
    return split;
  }

  /// Set the counts and boxes of an uncut split to those of all references.
  static void evaluate_uncut(Refs refs, Candidate& split) {
    BoxX4 bounds[2] = {BoxX4::empty(), BoxX4::empty()};
    split.n_left = 0;
    for (const BuildRef& ref : refs) {
      const unsigned on_left = centre_of(ref.box, split.axis) < split.plane;  // unpredictable, so not a branch
      split.n_left += on_left;
      bounds[on_left].grow(BoxX4::load(ref.box));
    }
    split.n_right = refs.size() - split.n_left;
    split.left = bounds[1].box();
    split.right = bounds[0].box();
  }

  /// Set the counts of a plane to those of all references.
  static void count(Refs refs, Candidate& split) {
    split.n_left = split.n_right = 0;
    for (const BuildRef& ref : refs) {
      const auto side = unsigned(side_of(ref.box, split.axis, split.plane));
      split.n_left += side & 1;
      split.n_right += side >> 1;
    }
  }

  /// The split with the least SAH over all axes.
  static std::optional<Candidate> cheapest(Candidate::Kind kind, const Box& box, BoxRule rule, const Measure& measure,
                                           BinsX8& grid) {
    double least = kInfinity;
    std::optional<Candidate> best;
    grid.visit(kind, box, rule, measure, false, [&](const Candidate& split) {
      const double sah = split.sah(measure);
      if (!(sah < least)) return;
      least = sah;
      best = split;
    });
    return best;
  }
};

}  // namespace fastlines
