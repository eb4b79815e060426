// What the builder does below one node: search for a split, carry it out, go on in the children.
#pragma once

#include <cmath>
#include <optional>
#include <stdexcept>

#include "../tree/tree.hpp"
#include "least.hpp"
#include "progress.hpp"
#include "settings.hpp"
#include "tasks.hpp"

namespace fastlines {

/// Where in the tree a node is, and what it may use.
struct Place {
  std::size_t depth = 0;
  std::size_t spare;   // references that it may add to its own
  int n_bad = 0;       // levels in a row above it that looked no better than a leaf
  int n_refines = 0;   // levels above it that were refined though the search said leaf
  double share = 1.0;  // of all the work
};

template <Primitives P>
class Subtree {
 public:
  Subtree(const P& prims, const Settings& settings, Progress& progress, Tasks& tasks, double margin)
      : prims_(prims), settings_(settings), progress_(progress), tasks_(tasks), margin_(margin) {
    for (const int k : settings.lookahead) ahead_.resize(std::max(ahead_.size(), std::size_t(k)));
  }

  Tree tree;
  LimitsHit limits_hit;
  Searched searched;

  /// Returns the cost.
  double build(Buffer<BuildRef> refs, const Box& box, const Place& place) {
    levels_.resize(settings_.limits.max_depth + 1);
    // Room for what many trees need, since to grow is to copy; `adopt` gives the pages back that are not used.
    const std::size_t more = std::min(place.spare, 3 * refs.size());
    tree.nodes.reserve(refs.size());
    tree.refs.reserve(refs.size() + more);
    return build_node(refs, box, place);
  }

  /// How many references a node at this depth can bring into leaves of the size asked for, by halving alone.
  std::size_t capacity(std::size_t depth) const {
    const Limits& limits = settings_.limits;
    const std::size_t levels = limits.max_depth - depth;
    return levels >= 63 || limits.max_leaf_refs > (std::size_t(-1) >> levels) ? std::size_t(-1)
                                                                              : limits.max_leaf_refs << levels;
  }

 private:
  struct Choice {
    double cost;
    std::optional<Candidate> split;  // none: a leaf
  };

  /// What a search holds at one of its levels.
  struct Ahead {
    struct Branch {
      Candidate split;
      double area_left, area_right;  // in parts of the node's
    };
    Buffer<BuildRef> left, right;
    std::vector<Branch> branches;
    std::vector<std::pair<double, std::size_t>> order;  // the branches by their cost at depth 1
    PlaneCounts counts;
  };

  struct Anything {
    bool operator()(const Candidate&) const { return true; }
  };

  double area_of(const Box& box) const { return box.area(margin_); }

  double cost_of_leaf(std::size_t n_refs) const { return settings_.cost.c_prim * double(n_refs); }

  /// No tree costs less than a leaf, or than one step.
  double at_least(std::size_t n_refs) const { return std::min(cost_of_leaf(n_refs), settings_.cost.c_trav); }

  /// Nor a cut box of which one more cut is made.
  double least_cut(const Box& box, std::size_t n_refs, std::size_t n_short, const PlaneCounts& counts) const {
    const double n = counts.least_cut(box, double(n_refs), double(n_short)) * (1 - 1e-9);
    return std::min(cost_of_leaf(n_refs), settings_.cost.c_trav + settings_.cost.c_prim * n);
  }

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
  void for_each_split(Refs refs, const Box& box, bool all, Visitor&& visitor) const {
    visit_splits(settings_.splits, prims_, refs, box, settings_.boxes, margin_, all, visitor);
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
      bool refused = false;
      const auto show = [&](const Candidate& split) {
        if (++n_seen % 64 == 0) progress_.check();
        if (allowed(split))
          consider(split, cost_of_leaf(split.n_left), cost_of_leaf(split.n_right));
        else
          refused = true;
      };
      for_each_split(refs, box, false, show);
      if (refused && !best.split) for_each_split(refs, box, true, show);
      if (refused && !best.split && settings_.boxes == BoxRule::tight)
        visit_wholes(settings_.splits, prims_, refs, box, margin_, show);
      return best;
    }
    return look_ahead(refs, box, lookahead, best, allowed);
  }

  /// Deeper than one level, by branch and bound (docs/theory.md): what looks cheapest at depth 1 is tried first, and
  /// nothing is carried out that can not become cheaper than the best so far. The split is that of exhaustive search:
  /// of equally cheap ones the first.
  template <class Allowed>
  Choice look_ahead(Refs refs, const Box& box, int lookahead, Choice best, Allowed&& allowed) {
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    const double area = area_of(box), c_trav = settings_.cost.c_trav;
    const bool cut = settings_.boxes == BoxRule::cut;
    auto& [left, right, branches, order, counts] = ahead_[std::size_t(lookahead - 1)];
    branches.clear();
    order.clear();
    counts.begin(box, refs.size(), margin_);
    for_each_split(refs, box, true, [&](const Candidate& split) {
      if (!allowed(split)) return;
      // Where areas are nothing, children count in full.
      const double area_left = area > 0.0 ? area_of(split.left) / area : 1.0,
                   area_right = area > 0.0 ? area_of(split.right) / area : 1.0;
      order.push_back({area_left * double(split.n_left) + area_right * double(split.n_right), branches.size()});
      branches.push_back({split, area_left, area_right});
      if (cut) counts.add(split);
    });
    if (!settings_.exhaustive || order.size() > settings_.beam) std::sort(order.begin(), order.end());
    order.resize(std::min(order.size(), settings_.beam));
    if (cut && lookahead == 2) counts.finish();

    std::size_t best_number = 0;
    for (const auto& [sah, number] : order) {
      const auto& [split, area_left, area_right] = branches[number];
      ++searched.candidates;
      double least_left = at_least(split.n_left), least_right = at_least(split.n_right);
      // What both children may cost together, weighed, for the split to be as cheap as the best.
      const double most = settings_.exhaustive ? no_limit : best.cost * (1 + 1e-9) - c_trav;
      if (area_left * least_left + area_right * least_right > most) continue;
      if (cut && lookahead == 2 && most < no_limit && area > 0.0) {
        const std::size_t n_short = split.n_left + split.n_right - refs.size();
        least_left = least_cut(split.left, split.n_left, n_short, counts);
        if (area_left * least_left + area_right * least_right > most) continue;
        least_right = least_cut(split.right, split.n_right, n_short, counts);
        if (area_left * least_left + area_right * least_right > most) continue;
      }
      ++searched.carried_out;
      partition(prims_, refs, split, left, right);
      const double most_left = area_left > 0.0 ? (most - area_right * least_right) / area_left : no_limit;
      const double cost_left = cost_ahead(left, split.left, lookahead - 1, most_left);
      if (cost_left > most_left) continue;
      const double most_right = area_right > 0.0 ? (most - area_left * cost_left) / area_right : no_limit;
      const double cost_right = cost_ahead(right, split.right, lookahead - 1, most_right);
      const double cost = cost_of(split, area_of(box), cost_left, cost_right, no_limit);
      if (cost < best.cost || (cost == best.cost && best.split && number < best_number)) {
        best = {cost, split};
        best_number = number;
      }
    }
    return best;
  }

  /// The cost of the cheapest tree of a depth, exactly if it is at most `limit`; else something above that.
  double cost_ahead(Refs refs, const Box& box, int lookahead, double limit) {
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    const double leaf = cost_of_leaf(refs.size()), most = std::nextafter(limit, no_limit);
    if (leaf < most) return best_split(refs, box, lookahead, leaf, Anything{}).cost;
    const Choice choice = best_split(refs, box, lookahead, most, Anything{});
    return choice.split ? choice.cost : no_limit;
  }

  /// What a split takes of the spare references: its duplicates, and one for an empty child, so that the references
  /// bound the nodes too.
  static std::size_t taken(std::size_t n_left, std::size_t n_right, std::size_t n_refs) {
    return n_left + n_right - n_refs + (n_left == 0) + (n_right == 0);
  }

  /// Lines that lie on each other can be cut, but not parted: each cut would look worth it, and no leaf get small.
  static bool parts(const Candidate& split, std::size_t n_refs) {
    return split.n_left < n_refs || split.n_right < n_refs;
  }

  /// What to do with a node: a split, or none for a leaf; whether it looks worth it, or refines what does not.
  struct Decision {
    std::optional<Candidate> split;
    bool good = false, refines = false;
  };

  Decision choose(Refs refs, const Box& box, const Place& place) {
    const Limits& limits = settings_.limits;
    const bool too_large = refs.size() > limits.max_leaf_refs;
    if (!too_large && (refs.size() <= limits.leaf_refs || box.side(box.longest_axis()) <= limits.leaf_size)) return {};

    bool over_refs = false;
    const auto allowed = [&](const Candidate& split) {
      if (taken(split.n_left, split.n_right, refs.size()) > place.spare) return !(over_refs = true);
      if (too_large && !parts(split, refs.size())) return false;
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
    limits_hit.refs += over_refs;
    if (place.depth == limits.max_depth) {
      limits_hit.depth += good;
      return {};
    }
    if (!choice.split && too_large) {
      // Take what looks least bad, unless that did not help levels above; where nothing divides the node, halve it.
      ++limits_hit.leaf_refs;
      if (place.n_bad == 0) choice = best_split(refs, box, settings_.lookahead.front(), no_limit, allowed);
      if (!choice.split)
        Median{}.visit(prims_, refs, box, BoxRule::tight, [&](const Candidate& half) { choice.split = half; });
    }
    const bool refines = !choice.split && place.n_refines < settings_.bad_refines;
    if (refines)
      Middle{}.visit(prims_, refs, box, settings_.boxes, [&](const Candidate& split) {
        if (allowed(split)) choice.split = split;
      });
    return {choice.split, good, refines};
  }

  /// Append the subtree of a node; returns its cost.
  double build_node(Buffer<BuildRef>& refs, const Box& box, const Place& place) {
    const std::size_t index = tree.nodes.size(), first_ref = tree.refs.size(), n_refs = refs.size();
    const std::size_t n_empty = n_empty_;
    check_size(index, first_ref + n_refs);
    tree.nodes.push_back({box, 0, std::uint32_t(first_ref), 0});
    auto [split, good, refines] = choose(refs, box, place);
    if (!split) {
      progress_.add(place.share);
      return make_leaf(index, refs);
    }

    // Duplicates are paid out of the spare references; the rest goes to the children by number.
    auto& [left, right] = levels_[place.depth];
    const bool may_prune = settings_.prune && n_refs <= settings_.limits.max_leaf_refs;
    const bool in_place = n_refs > kLarge && !may_prune;
    if (in_place) left = std::move(refs);
    partition(prims_, in_place ? left : refs, *split, left, right);
    if (in_place && left.size() <= kLarge) {
      // The large memory is of no more use: nobody below would pass it on.
      Buffer<BuildRef> few;
      few.assign(left);
      left = std::move(few);
    }
    if ((!Curves<P> || estimates(settings_.splits)) && settings_.boxes == BoxRule::tight) {
      // What was counted plane by plane may be off by some roundings, or a sample's.
      split->left = hull(left);
      split->right = hull(right);
    }
    const std::size_t spare = place.spare - taken(left.size(), right.size(), n_refs);
    const double part = double(left.size()) / double(left.size() + right.size());
    const int n_bad = good ? 0 : place.n_bad + 1, n_refines = place.n_refines + refines;
    const Place in_left{place.depth + 1, std::size_t(double(spare) * part), n_bad, n_refines, place.share * part};
    const Place in_right{place.depth + 1, spare - in_left.spare, n_bad, n_refines, place.share - in_left.share};

    const bool large = std::min(left.size(), right.size()) > kTask;
    const auto [cost_left, cost_right] = large && tasks_.shared()
                                             ? build_side_by_side(index, *split, in_left, in_right)
                                             : build_in_turn(index, *split, in_left, in_right, !large);
    tree.nodes[index].n_refs = std::uint32_t(tree.refs.size() - first_ref);
    const double cost = cost_of(*split, area_of(box), cost_left, cost_right, std::numeric_limits<double>::infinity());
    if (!may_prune || cost < cost_of_leaf(n_refs)) return cost;
    tree.nodes.resize(index + 1);
    tree.refs.resize(first_ref);
    n_empty_ = n_empty;
    return make_leaf(index, refs);
  }

  /// What the left child leaves of its share of references may be passed on to the right one. Large nodes do not, so
  /// that it can not be seen whether they were built side by side.
  std::pair<double, double> build_in_turn(std::size_t index, const Candidate& split, const Place& in_left,
                                          Place in_right, bool pass_on) {
    auto& [left, right] = levels_[in_left.depth - 1];
    const std::size_t before = n_used(), room = std::max<std::size_t>(left.size(), 1) + in_left.spare;
    const double cost_left = build_node(left, split.left, in_left);
    if (pass_on) in_right.spare += room - (n_used() - before);
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    return {cost_left, build_node(right, split.right, in_right)};
  }

  /// Where somebody takes the right child, it becomes a tree of its own, which is appended when both are finished.
  std::pair<double, double> build_side_by_side(std::size_t index, const Candidate& split, const Place& in_left,
                                               const Place& in_right) {
    auto& [left, right] = levels_[in_left.depth - 1];
    std::optional<Subtree> beside;
    double cost_left, cost_right;
    const auto stop = [&] {
      tasks_.note(std::current_exception());
      progress_.cancel.store(true);
    };
    Tasks::Task task([&] {
      try {
        beside.emplace(prims_, settings_, progress_, tasks_, margin_);
        cost_right = beside->build(std::move(right), split.right, in_right);
      } catch (...) {
        stop();
        throw;
      }
    });
    tasks_.fork(task);
    try {
      cost_left = build_node(left, split.left, in_left);
    } catch (...) {
      stop();
      try {
        if (!tasks_.take_back(task)) tasks_.join(task);
      } catch (...) {
      }
      throw;
    }
    if (tasks_.take_back(task)) {
      tree.nodes[index].right = std::uint32_t(tree.nodes.size());
      return {cost_left, build_node(right, split.right, in_right)};
    }
    tasks_.join(task);
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    append(tree, beside->tree);
    n_empty_ += beside->n_empty_;
    limits_hit += beside->limits_hit;
    searched += beside->searched;
    return {cost_left, cost_right};
  }

  /// Of the budget: references, and leaves without any.
  std::size_t n_used() const { return tree.refs.size() + n_empty_; }

  double make_leaf(std::size_t index, Refs refs) {
    tree.nodes[index].right = 0;
    tree.nodes[index].n_refs = std::uint32_t(refs.size());
    for (const BuildRef& ref : refs) tree.refs.push_back(ref.ref);
    n_empty_ += refs.empty();
    return cost_of_leaf(refs.size());
  }

  // With more references than these a child is worth a task, and a node gives its memory to its left child.
  static constexpr std::size_t kTask = 512, kLarge = 1024;

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  Tasks& tasks_;
  double margin_;  // by which boxes are grown before they are measured
  std::vector<std::pair<Buffer<BuildRef>, Buffer<BuildRef>>> levels_;  // the children of the open nodes
  std::vector<Ahead> ahead_;                                           // by depth of the search
  std::size_t n_empty_ = 0;                                            // leaves without references
};

}  // namespace fastlines
