// The general builder (thesis §4.1): at each node search for the cheapest tree of a given depth over all candidate
// splits, carry out its first split, and go on in the children. Depth 1 is SAH.
//
//   best_split(refs, box, 0) = leaf, cost n·c_prim
//   best_split(refs, box, k) = the cheaper of the leaf and, over SPLITS,
//       c_trav + (SA(l)·best_split(l, k − 1) + SA(r)·best_split(r, k − 1)) / SA(box)
//
// Where long lines cross, the first levels of a good tree look worse than a leaf, and a search of small depth never
// gets past them. So some levels in a row may be bad: the builder goes through with the best split all the same, and
// when the subtree is finished compares what it cost with the leaf, exactly. Each node chooses "leaf or children" under
// the same cost, from the bottom up, so what is left is the cheapest of all prunings of the deep tree.
#pragma once

#include <optional>
#include <stdexcept>

#include "../tree/tree.hpp"
#include "progress.hpp"
#include "settings.hpp"

namespace fastlines {

template <Primitives P>
class Builder {
 public:
  Builder(const P& prims, const Settings& settings, Progress& progress)
      : prims_(prims), settings_(settings), progress_(progress) {
    for (const int k : settings.lookahead) scratch_.resize(std::max(scratch_.size(), std::size_t(k)));
  }

  Tree build() {
    std::vector<BuildRef> refs = whole_references(prims_);
    Box box = hull(refs);
    if (refs.empty()) box = Box{{0, 0, 0}, {0, 0, 0}};
    margin_ = settings_.radius_hint * box.side(box.longest_axis());
    if (refs.size() > capacity(0))
      throw std::invalid_argument("max_leaf_refs and max_depth leave no room for all references");
    if (refs.size() > settings_.limits.max_refs)
      throw std::invalid_argument("max_refs is less than the number of primitives");
    const std::size_t spare = settings_.limits.max_refs - refs.size();
    build_node(std::move(refs), box, Place{.spare = spare});
    return std::move(tree_);
  }

  const LimitsHit& limits_hit() const { return hit_; }

 private:
  struct Choice {
    double cost;
    std::optional<Candidate> split;  // none: a leaf
  };

  struct Anything {
    bool operator()(const Candidate&) const { return true; }
  };

  /// Where in the tree a node is, and what it may use.
  struct Place {
    std::size_t depth = 0;
    std::size_t spare;   // references that it may add to its own
    int n_bad = 0;       // levels in a row above it that looked no better than a leaf
    double share = 1.0;  // of all the work
  };

  double area_of(const Box& box) const { return box.area(margin_); }

  double cost_of_leaf(std::size_t n_refs) const { return settings_.cost.c_prim * double(n_refs); }

  double at_least(std::size_t n_refs) const { return std::min(cost_of_leaf(n_refs), settings_.cost.c_trav); }

  /// The cost of a split whose children cost `left` and `right`; ∞ without a division where that is surely above
  /// `limit`.
  double cost_of(const Candidate& split, double area, double left, double right, double limit) const {
    const double c_trav = settings_.cost.c_trav;
    if (area == 0.0) return c_trav + (left + right);
    const double weighed = area_of(split.left) * left + area_of(split.right) * right;
    if (weighed > (limit - c_trav) * area * (1 + 1e-12)) return std::numeric_limits<double>::infinity();
    return c_trav + weighed / area;
  }

  template <class Visitor>
  void for_each_split(Refs refs, const Box& box, Visitor&& visitor) const {
    visit_splits(settings_.splits, prims_, refs, box, settings_.boxes, visitor);
  }

  /// The first split of the cheapest tree of depth `lookahead`, among those that `allowed` lets pass.
  template <class Allowed>
  Choice best_split(Refs refs, const Box& box, int lookahead, double limit, Allowed&& allowed) {
    Choice best{limit, {}};
    if (lookahead == 0 || limit <= settings_.cost.c_trav) return best;  // no split costs less than one step
    progress_.check();
    const double area = area_of(box);
    const auto consider = [&](const Candidate& split, double left, double right) {
      const double cost = cost_of(split, area, left, right, best.cost);
      if (cost < best.cost) best = {cost, split};
    };
    if (lookahead == 1) {
      unsigned n_seen = 0;
      for_each_split(refs, box, [&](const Candidate& split) {
        if (++n_seen % 64 == 0) progress_.check();
        if (allowed(split)) consider(split, cost_of_leaf(split.n_left), cost_of_leaf(split.n_right));
      });
      return best;
    }
    std::vector<Candidate> candidates;
    for_each_split(refs, box, [&](const Candidate& split) {
      if (allowed(split)) candidates.push_back(split);
    });
    auto& [left, right] = scratch_[std::size_t(lookahead - 1)];
    for (const Candidate& split : candidates) {
      // No tree over n references costs less than a leaf of them or than one step, whichever is less.
      if (cost_of(split, area, at_least(split.n_left), at_least(split.n_right), best.cost) >= best.cost) continue;
      partition(prims_, refs, split, left, right);
      const double cost_left = best_split(left, split.left, lookahead - 1, cost_of_leaf(left.size()), Anything{}).cost;
      const double cost_right =
          best_split(right, split.right, lookahead - 1, cost_of_leaf(right.size()), Anything{}).cost;
      consider(split, cost_left, cost_right);
    }
    return best;
  }

  /// How many references a node at this depth can bring into leaves of the size asked for, by halving alone.
  std::size_t capacity(std::size_t depth) const {
    const Limits& limits = settings_.limits;
    const std::size_t levels = limits.max_depth - depth;
    return levels >= 63 || limits.max_leaf_refs > (std::size_t(-1) >> levels) ? std::size_t(-1)
                                                                              : limits.max_leaf_refs << levels;
  }

  /// What to do with a node: a split, or none for a leaf; and whether the split looks worth it.
  std::pair<std::optional<Candidate>, bool> choose(Refs refs, const Box& box, const Place& place) {
    const Limits& limits = settings_.limits;
    const bool too_large = refs.size() > limits.max_leaf_refs;
    if (!too_large && (refs.size() <= limits.leaf_refs || box.side(box.longest_axis()) <= limits.leaf_size)) return {};

    bool over_refs = false;
    const auto allowed = [&](const Candidate& split) {
      if (split.n_left + split.n_right > refs.size() + place.spare) return !(over_refs = true);
      if (place.depth == limits.max_depth) return true;  // looked at below
      return std::max(split.n_left, split.n_right) <= capacity(place.depth + 1);
    };
    const double leaf = cost_of_leaf(refs.size());
    const bool may_be_bad = place.n_bad < settings_.bad_levels && leaf > settings_.cost.c_trav;
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    Choice choice;
    bool good = false;
    for (const int lookahead : settings_.lookahead) {
      choice = best_split(refs, box, lookahead, may_be_bad ? no_limit : leaf, allowed);
      good = choice.split && choice.cost < leaf;
      if (good) break;
    }
    hit_.refs += over_refs;
    if (place.depth == limits.max_depth) {
      hit_.depth += good;
      return {};
    }
    if (!choice.split && too_large) {
      // Take what looks least bad, unless that did not help levels above; where nothing divides the node, halve it.
      ++hit_.leaf_refs;
      if (place.n_bad == 0) choice = best_split(refs, box, settings_.lookahead.front(), no_limit, allowed);
      if (!choice.split)
        Median{}.visit(prims_, refs, box, BoxRule::tight, [&](const Candidate& half) { choice.split = half; });
    }
    return {choice.split, good};
  }

  /// Append the subtree of a node; returns its cost.
  double build_node(std::vector<BuildRef> refs, const Box& box, const Place& place) {
    const std::size_t index = tree_.nodes.size(), first_ref = tree_.refs.size(), n_refs = refs.size();
    if (index >= 0xffff'fff0 || first_ref + n_refs > 0xffff'fff0)
      throw std::length_error("a tree holds at most 2^32 nodes and references; set max_refs to less");
    tree_.nodes.push_back({box, 0, std::uint32_t(first_ref), 0});
    auto [split, good] = choose(refs, box, place);
    if (!split) {
      progress_.add(place.share);
      return make_leaf(index, refs);
    }

    // Duplicates are paid out of the spare references; the rest goes to the children by number.
    std::vector<BuildRef> left, right;
    partition(prims_, refs, *split, left, right);
    if (!Curves<P> && settings_.boxes == BoxRule::tight) {
      // What was counted plane by plane may be an ulp off; only curves promise not to.
      split->left = hull(left);
      split->right = hull(right);
    }
    const std::size_t spare = place.spare - (left.size() + right.size() - n_refs);
    const double part = double(left.size()) / double(left.size() + right.size());
    const int n_bad = good ? 0 : place.n_bad + 1;
    const Place in_left{place.depth + 1, std::size_t(double(spare) * part), n_bad, place.share * part};
    const Place in_right{place.depth + 1, spare - in_left.spare, n_bad, place.share - in_left.share};

    const bool may_prune = settings_.prune && !good && n_refs <= settings_.limits.max_leaf_refs;
    if (!may_prune) refs = {};
    const double cost_left = build_node(std::move(left), split->left, in_left);
    tree_.nodes[index].right = std::uint32_t(tree_.nodes.size());
    const double cost_right = build_node(std::move(right), split->right, in_right);
    tree_.nodes[index].n_refs = std::uint32_t(tree_.refs.size() - first_ref);
    const double cost = cost_of(*split, area_of(box), cost_left, cost_right, std::numeric_limits<double>::infinity());
    if (!may_prune || cost < cost_of_leaf(n_refs)) return cost;
    tree_.nodes.resize(index + 1);
    tree_.refs.resize(first_ref);
    return make_leaf(index, refs);
  }

  double make_leaf(std::size_t index, Refs refs) {
    tree_.nodes[index].right = 0;
    tree_.nodes[index].n_refs = std::uint32_t(refs.size());
    for (const BuildRef& ref : refs) tree_.refs.push_back(ref.ref);
    return cost_of_leaf(refs.size());
  }

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  Tree tree_;
  LimitsHit hit_;
  double margin_ = 0.0;  // by which boxes are grown before they are measured
  std::vector<std::pair<std::vector<BuildRef>, std::vector<BuildRef>>> scratch_;
};

}  // namespace fastlines
