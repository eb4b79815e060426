// The search for the split of a node (thesis §4.1): the first split of the cheapest tree of a given depth. Branch and
// bound finds that tree (build/lookahead_bounds.hpp).
#pragma once

#include <bit>
#include <cassert>
#include <cmath>
#include <optional>

#include "../parallel/progress.hpp"
#include "../splits/partition.hpp"
#include "lookahead_bounds.hpp"
#include "settings.hpp"

namespace fastlines {

/// Searches for splits, one node at a time. A search holds no more than one buffer per level of its depth.
template <Primitives P>
class Lookahead {
 public:
  /// The result of a search.
  struct Choice {
    double cost;                     ///< of the cheapest tree; the limit of the search if no tree is cheaper
    std::optional<Candidate> split;  ///< the first split of that tree; none for a leaf
  };

  /// Boxes are measured with `margin` added on all sides.
  Lookahead(const P& prims, const Settings& settings, Progress& progress, double margin)
      : prims_(prims), settings_(settings), progress_(progress), measure_{margin, settings.lanes} {
    assert(std::has_single_bit(settings.lanes));
    for (const int k : settings.lookahead) levels_.resize(std::max(levels_.size(), std::size_t(k)));
  }

  SearchCounts search_counts;  ///< of all searches so far

  double cost_of_leaf(std::size_t n_refs) const { return settings_.cost.c_prim * measure_.tests(n_refs); }

  /// The cost of a split of a node whose children cost `left` and `right`.
  double cost_of(const Candidate& split, const Box& box, double left, double right) const {
    return cost_of(split, area_of(box), left, right, kNoLimit);
  }

  /// The first split of the cheapest tree of depth `lookahead`, among the splits that `allowed` accepts; none if no
  /// tree costs less than `limit`.
  template <class Allowed>
  Choice best_split(Refs refs, const Box& box, int lookahead, double limit, const Allowed& allowed) {
    Choice best{limit, {}};
    if (lookahead == 0 || limit <= settings_.cost.c_trav) return best;  // no split costs less than one traversal step
    progress_.check();
    const double area = area_of(box);
    const auto consider = [&](const Candidate& split, double left, double right) {
      const double cost = cost_of(split, area, left, right, best.cost);
      if (cost < best.cost) best = {cost, split};
    };
    if (lookahead == 1) {
      bool refused = false;
      const auto visitor = [&](const Candidate& split) {
        if (allowed(split))
          consider(split, cost_of_leaf(split.n_left), cost_of_leaf(split.n_right));
        else
          refused = true;
      };
      for_each_split(refs, box, false, visitor);
      if (refused && !best.split) for_each_split(refs, box, true, visitor);
      if (refused && !best.split && settings_.boxes == BoxRule::tight)
        visit_uncut(settings_.splits, prims_, refs, box, measure_, visitor);
      return best;
    }
    return look_ahead(refs, box, lookahead, best, allowed);
  }

  /// The cheapest uncut split, for nodes of any size: every reference stays whole.
  template <class Allowed>
  Choice best_uncut(Refs refs, const Box& box, double limit, const Allowed& allowed) const {
    Choice best{limit, {}};
    if (settings_.boxes == BoxRule::cut) return best;
    const double area = area_of(box);
    visit_uncut(settings_.splits, prims_, refs, box, measure_, [&](const Candidate& split) {
      // Split sets also offer planes where all centres coincide.
      if (split.kind == Candidate::Kind::plane || !allowed(split)) return;
      const double left = cost_of_leaf(split.n_left), right = cost_of_leaf(split.n_right);
      const double cost = cost_of(split, area, left, right, best.cost);
      if (cost < best.cost) best = {cost, split};
    });
    return best;
  }

 private:
  /// The buffers of one level of the search.
  struct Level {
    struct Branch {
      Candidate split;
      double area_left, area_right;    // as a fraction of the node's area
      double bound_left, bound_right;  // lower bounds on the children's costs
      std::size_t plane;               // index among the planes of the split's axis
    };
    Buffer<BuildRef> left, right;
    std::vector<Branch> branches;
    std::vector<std::pair<double, std::size_t>> order;  // an estimate of the cost, and the index of the branch
    LookaheadBounds bounds;
  };

  static constexpr double kNoLimit = kInfinity;

  double area_of(const Box& box) const { return measure_.area(box); }

  /// The cost of a split, or ∞ if it is certain to exceed `limit`; the early exit saves a division.
  double cost_of(const Candidate& split, double area, double left, double right, double limit) const {
    const double c_trav = settings_.cost.c_trav;
    if (area == 0.0) return c_trav + (left + right);
    const double weighted = area_of(split.left) * left + area_of(split.right) * right;
    if (weighted > (limit - c_trav) * area * (1 + 1e-12)) return kNoLimit;
    return c_trav + weighted / area;
  }

  /// A lower bound on the cost of any tree: that of a leaf, or of one traversal step.
  double lower_bound(std::size_t n_refs) const { return std::min(cost_of_leaf(n_refs), settings_.cost.c_trav); }

  template <class Visitor>
  void for_each_split(Refs refs, const Box& box, bool all, const Visitor& visitor) const {
    unsigned n_visited = 0;
    visit_splits(settings_.splits, prims_, refs, box, settings_.boxes, measure_, all, [&](const Candidate& split) {
      if (++n_visited % 64 == 0) progress_.check();  // finding one split can take time linear in the node
      visitor(split);
    });
  }

  /// A search of more than one level, by branch and bound. The most promising branches come first, and
  /// a branch that cannot beat the best so far is skipped. The result is that of exhaustive search: the first of
  /// equally cheap splits.
  template <class Allowed>
  Choice look_ahead(Refs refs, const Box& box, int lookahead, Choice best, const Allowed& allowed) {
    const double area = area_of(box), c_trav = settings_.cost.c_trav;
    const bool exhaustive = settings_.exhaustive;
    const bool by_bounds = lookahead <= 3 && !exhaustive && has_bounds(refs.size(), area);
    auto& [left, right, branches, order, bounds] = levels_[std::size_t(lookahead - 1)];
    branches.clear();
    order.clear();
    bounds.reset(box, measure_.margin);

    // List the candidates.
    for_each_split(refs, box, true, [&](const Candidate& split) {
      const std::size_t plane = by_bounds ? bounds.add(split) : 0;
      if (!allowed(split)) return;
      // In a node without area, children count in full.
      const double area_left = area > 0.0 ? area_of(split.left) / area : 1.0,
                   area_right = area > 0.0 ? area_of(split.right) / area : 1.0;
      order.push_back(
          {area_left * measure_.tests(split.n_left) + area_right * measure_.tests(split.n_right), branches.size()});
      branches.push_back({split, area_left, area_right, lower_bound(split.n_left), lower_bound(split.n_right), plane});
    });
    // Order the branches, and keep as many as the beam allows.
    if ((!exhaustive && !by_bounds) || order.size() > settings_.beam) std::sort(order.begin(), order.end());
    order.resize(std::min(order.size(), settings_.beam));
    search_counts.candidates += order.size();
    // Raise the lower bounds.
    if (by_bounds && !order.empty()) {
      bounds.compute(refs, lookahead == 3, c_trav / settings_.cost.c_prim);
      apply_bounds(bounds, branches, order, best.cost);
    }

    // Partition, and search the children.
    std::size_t best_index = 0;
    for (const auto& [_, index] : order) {
      const auto& [split, area_left, area_right, bound_left, bound_right, plane] = branches[index];
      // The budget of both children, weighted by area, for the split to be as cheap as the best.
      const double budget = exhaustive ? kNoLimit : best.cost * (1 + 1e-9) - c_trav;
      if (area_left * bound_left + area_right * bound_right > budget) continue;
      ++search_counts.partitioned;
      partition(prims_, refs, split, left, right);
      const double budget_left = area_left > 0.0 ? (budget - area_right * bound_right) / area_left : kNoLimit;
      const double cost_left = cost_ahead(left, split.left, lookahead - 1, budget_left);
      if (cost_left > budget_left) continue;
      const double budget_right = area_right > 0.0 ? (budget - area_left * cost_left) / area_right : kNoLimit;
      const double cost_right = cost_ahead(right, split.right, lookahead - 1, budget_right);
      const double cost = cost_of(split, box, cost_left, cost_right);
      if (cost < best.cost || (cost == best.cost && best.split && index < best_index)) {
        best = {cost, split};
        best_index = index;
      }
    }
    return best;
  }

  /// Whether `LookaheadBounds` bounds the children's costs. The bounds need parts that end where their curve ends or at
  /// the plane. Their tables grow with the square of the number of planes, and count in float32.
  bool has_bounds(std::size_t n_refs, double area) const {
    const int n_planes = n_kept_planes(settings_.splits);
    return Curves<P> && settings_.boxes == BoxRule::cut && 0 < n_planes && n_planes <= 256 && n_refs < (1 << 24) &&
           area > 0.0;
  }

  /// Raise the lower bounds of the children, drop branches that exceed `limit`, and sort the others by their bounds.
  void apply_bounds(const LookaheadBounds& bounds, std::vector<typename Level::Branch>& branches,
                    std::vector<std::pair<double, std::size_t>>& order, double limit) const {
    const auto& [c_trav, c_prim] = settings_.cost;
    const auto raise = [&](double& least, double area, double tests, std::size_t n_refs) {
      if (area > 0.0 && tests >= 0.0)
        least = std::max(least, std::min(cost_of_leaf(n_refs), c_trav + c_prim * tests / area));
    };
    std::size_t n_left = 0;
    for (const auto& [_, index] : order) {
      auto& [split, area_left, area_right, bound_left, bound_right, plane] = branches[index];
      const auto [left, right] = bounds.lower_bounds(split.axis, plane);
      raise(bound_left, area_left, left, split.n_left);
      raise(bound_right, area_right, right, split.n_right);
      const double least = area_left * bound_left + area_right * bound_right;
      if (c_trav + least <= limit * (1 + 1e-9)) order[n_left++] = {least, index};
    }
    order.resize(n_left);
    std::sort(order.begin(), order.end());
  }

  /// The cost of the cheapest tree of depth `lookahead`: exact if it is at most `limit`, else any value above `limit`.
  double cost_ahead(Refs refs, const Box& box, int lookahead, double limit) {
    const double leaf = cost_of_leaf(refs.size()), budget = std::nextafter(limit, kNoLimit);
    const auto allow_all = [](const Candidate&) { return true; };
    if (leaf < budget) return best_split(refs, box, lookahead, leaf, allow_all).cost;
    const Choice choice = best_split(refs, box, lookahead, budget, allow_all);
    return choice.split ? choice.cost : kNoLimit;
  }

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  Measure measure_;
  std::vector<Level> levels_;  // by levels that remain to search, less one
};

}  // namespace fastlines
