// The search for a node's split: the first of the cheapest tree of a given depth over all candidates (thesis §4.1), by
// branch and bound (docs/theory.md, theorem 9).
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

template <Primitives P>
class Lookahead {
 public:
  struct Found {
    double cost;
    std::optional<Candidate> split;  // none: a leaf
  };

  Lookahead(const P& prims, const Settings& settings, Progress& progress, double margin)
      : prims_(prims), settings_(settings), progress_(progress), measure_{margin, settings.lanes} {
    assert(std::has_single_bit(settings.lanes));
    for (const int k : settings.lookahead) levels_.resize(std::max(levels_.size(), std::size_t(k)));
  }

  Searched searched;

  double cost_of_leaf(std::size_t n_refs) const { return settings_.cost.c_prim * measure_.tests(n_refs); }

  /// The cost of a split of a node whose children cost `left` and `right`.
  double cost_of(const Candidate& split, const Box& box, double left, double right) const {
    return cost_of(split, area_of(box), left, right, kNoLimit);
  }

  /// The first split of the cheapest tree of depth `lookahead`, among those that `allowed` lets pass.
  template <class Allowed>
  Found best_split(Refs refs, const Box& box, int lookahead, double limit, Allowed&& allowed) {
    Found best{limit, {}};
    if (lookahead == 0 || limit <= settings_.cost.c_trav) return best;  // no split costs less than one step
    progress_.check();
    const double area = area_of(box);
    const auto consider = [&](const Candidate& split, double left, double right) {
      const double cost = cost_of(split, area, left, right, best.cost);
      if (cost < best.cost) best = {cost, split};
    };
    if (lookahead == 1) {
      bool refused = false;
      const auto show = [&](const Candidate& split) {
        if (allowed(split))
          consider(split, cost_of_leaf(split.n_left), cost_of_leaf(split.n_right));
        else
          refused = true;
      };
      for_each_split(refs, box, false, show);
      if (refused && !best.split) for_each_split(refs, box, true, show);
      if (refused && !best.split && settings_.boxes == BoxRule::tight)
        visit_wholes(settings_.splits, prims_, refs, box, measure_, show);
      return best;
    }
    return look_ahead(refs, box, lookahead, best, allowed);
  }

  /// The cheapest split into whole references, of nodes of any size.
  template <class Allowed>
  Found best_whole(Refs refs, const Box& box, double limit, Allowed&& allowed) const {
    Found best{limit, {}};
    if (settings_.boxes == BoxRule::cut) return best;
    const double area = area_of(box);
    visit_wholes(settings_.splits, prims_, refs, box, measure_, [&](const Candidate& split) {
      // Where all centres are the same, sets show planes.
      if (split.kind == Candidate::Kind::plane || !allowed(split)) return;
      const double left = cost_of_leaf(split.n_left), right = cost_of_leaf(split.n_right);
      const double cost = cost_of(split, area, left, right, best.cost);
      if (cost < best.cost) best = {cost, split};
    });
    return best;
  }

 private:
  /// What a search holds at one of its levels.
  struct Level {
    struct Branch {
      Candidate split;
      double area_left, area_right;    // in parts of the node's
      double least_left, least_right;  // what the children cost at least
      std::size_t plane;               // of all those across its axis
    };
    Buffer<BuildRef> left, right;
    std::vector<Branch> branches;
    std::vector<std::pair<double, std::size_t>> order;  // the branches by what looks cheapest
    LookaheadBounds bounds;
  };

  struct Anything {
    bool operator()(const Candidate&) const { return true; }
  };

  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();

  double area_of(const Box& box) const { return measure_.area(box); }

  /// ∞ without a division where that is surely above `limit`.
  double cost_of(const Candidate& split, double area, double left, double right, double limit) const {
    const double c_trav = settings_.cost.c_trav;
    if (area == 0.0) return c_trav + (left + right);
    const double weighed = area_of(split.left) * left + area_of(split.right) * right;
    if (weighed > (limit - c_trav) * area * (1 + 1e-12)) return kNoLimit;
    return c_trav + weighed / area;
  }

  /// No tree costs less than a leaf, or than one step.
  double at_least(std::size_t n_refs) const { return std::min(cost_of_leaf(n_refs), settings_.cost.c_trav); }

  template <class Visitor>
  void for_each_split(Refs refs, const Box& box, bool all, Visitor&& visitor) const {
    unsigned n_seen = 0;
    visit_splits(settings_.splits, prims_, refs, box, settings_.boxes, measure_, all, [&](const Candidate& split) {
      if (++n_seen % 64 == 0) progress_.check();  // to find a split may take as long as the node is large
      visitor(split);
    });
  }

  /// Deeper than one level, by branch and bound (docs/theory.md): what looks cheapest is tried first, and nothing is
  /// carried out that can not become cheaper than the best so far. The split is that of exhaustive search: of equally
  /// cheap ones the first.
  template <class Allowed>
  Found look_ahead(Refs refs, const Box& box, int lookahead, Found best, Allowed&& allowed) {
    const double area = area_of(box), c_trav = settings_.cost.c_trav;
    const bool exhaustive = settings_.exhaustive;
    const bool by_bounds = lookahead <= 3 && !exhaustive && has_bounds(refs.size(), area);
    auto& [left, right, branches, order, bounds] = levels_[std::size_t(lookahead - 1)];
    branches.clear();
    order.clear();
    bounds.begin(box, measure_.margin);
    for_each_split(refs, box, true, [&](const Candidate& split) {
      const std::size_t plane = by_bounds ? bounds.add(split) : 0;
      if (!allowed(split)) return;
      // Where areas are nothing, children count in full.
      const double area_left = area > 0.0 ? area_of(split.left) / area : 1.0,
                   area_right = area > 0.0 ? area_of(split.right) / area : 1.0;
      order.push_back(
          {area_left * measure_.tests(split.n_left) + area_right * measure_.tests(split.n_right), branches.size()});
      branches.push_back({split, area_left, area_right, at_least(split.n_left), at_least(split.n_right), plane});
    });
    if ((!exhaustive && !by_bounds) || order.size() > settings_.beam) std::sort(order.begin(), order.end());
    order.resize(std::min(order.size(), settings_.beam));
    searched.candidates += order.size();
    if (by_bounds && !order.empty()) {
      bounds.count(refs, lookahead == 3, c_trav / settings_.cost.c_prim);
      bound_by(bounds, branches, order, best.cost);
    }

    std::size_t best_number = 0;
    for (const auto& [_, number] : order) {
      const auto& [split, area_left, area_right, least_left, least_right, plane] = branches[number];
      // What both children may cost together, weighed, for the split to be as cheap as the best.
      const double most = exhaustive ? kNoLimit : best.cost * (1 + 1e-9) - c_trav;
      if (area_left * least_left + area_right * least_right > most) continue;
      ++searched.carried_out;
      partition(prims_, refs, split, left, right);
      const double most_left = area_left > 0.0 ? (most - area_right * least_right) / area_left : kNoLimit;
      const double cost_left = cost_ahead(left, split.left, lookahead - 1, most_left);
      if (cost_left > most_left) continue;
      const double most_right = area_right > 0.0 ? (most - area_left * cost_left) / area_right : kNoLimit;
      const double cost_right = cost_ahead(right, split.right, lookahead - 1, most_right);
      const double cost = cost_of(split, box, cost_left, cost_right);
      if (cost < best.cost || (cost == best.cost && best.split && number < best_number)) {
        best = {cost, split};
        best_number = number;
      }
    }
    return best;
  }

  /// Whether bounds of planes bound what children cost: parts of a curve end where it ends, or at the plane. Tables
  /// grow with the square of the number of planes, and count in float32.
  bool has_bounds(std::size_t n_refs, double area) const {
    const int n_planes = n_kept_planes(settings_.splits);
    return Curves<P> && settings_.boxes == BoxRule::cut && 0 < n_planes && n_planes <= 256 && n_refs < (1 << 24) &&
           area > 0.0;
  }

  /// Raise what children cost at least, and try what then looks cheapest first; leave out what costs too much.
  void bound_by(const LookaheadBounds& bounds, std::vector<typename Level::Branch>& branches,
                std::vector<std::pair<double, std::size_t>>& order, double limit) const {
    const auto& [c_trav, c_prim] = settings_.cost;
    const auto raise = [&](double& least, double area, double tests, std::size_t n_refs) {
      if (area > 0.0 && tests >= 0.0)
        least = std::max(least, std::min(cost_of_leaf(n_refs), c_trav + c_prim * tests / area));
    };
    std::size_t n_left = 0;
    for (const auto& [_, number] : order) {
      auto& [split, area_left, area_right, least_left, least_right, plane] = branches[number];
      const auto [left, right] = bounds.least(split.axis, plane);
      raise(least_left, area_left, left, split.n_left);
      raise(least_right, area_right, right, split.n_right);
      const double least = area_left * least_left + area_right * least_right;
      if (c_trav + least <= limit * (1 + 1e-9)) order[n_left++] = {least, number};
    }
    order.resize(n_left);
    std::sort(order.begin(), order.end());
  }

  /// The cost of the cheapest tree of a depth, exactly if it is at most `limit`; else something above that.
  double cost_ahead(Refs refs, const Box& box, int lookahead, double limit) {
    const double leaf = cost_of_leaf(refs.size()), most = std::nextafter(limit, kNoLimit);
    if (leaf < most) return best_split(refs, box, lookahead, leaf, Anything{}).cost;
    const Found choice = best_split(refs, box, lookahead, most, Anything{});
    return choice.split ? choice.cost : kNoLimit;
  }

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  Measure measure_;
  std::vector<Level> levels_;  // by depth of the search
};

}  // namespace fastlines
