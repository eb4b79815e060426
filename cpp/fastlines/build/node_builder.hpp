// What the builder does below one node: search for a split, carry it out, go on in the children.
#pragma once

#include <exception>
#include <optional>

#include "../parallel/task_group.hpp"
#include "../splits/retraced_lines.hpp"
#include "../tree/tree.hpp"
#include "lookahead.hpp"

namespace fastlines {

/// Where in the tree a node is, and what it may use.
struct NodeContext {
  std::size_t depth = 0;
  std::size_t spare;   // references that it may add to its own
  int n_bad = 0;       // levels in a row above it that looked no better than a leaf
  int n_refines = 0;   // levels above it that were refined though the search said leaf
  double share = 1.0;  // of all the work
};

template <Primitives P>
class NodeBuilder {
 public:
  NodeBuilder(const P& prims, const Settings& settings, Progress& progress, TaskGroup& tasks, double scene_side)
      : prims_(prims),
        settings_(settings),
        progress_(progress),
        tasks_(tasks),
        scene_side_(scene_side),
        lookahead_(prims, settings, progress, settings.radius_hint * scene_side) {}

  Tree tree;
  LimitsHit limits_hit;

  const Searched& searched() const { return lookahead_.searched; }

  /// Returns the cost.
  double build(Buffer<BuildRef> refs, const Box& box, const NodeContext& context) {
    levels_.resize(settings_.limits.max_depth + 1);
    // Room for what many trees need, since to grow is to copy; `adopt` gives the pages back that are not used.
    const std::size_t more = std::min(context.spare, 3 * refs.size());
    tree.nodes.reserve(refs.size());
    tree.refs.reserve(refs.size() + more);
    return build_node(refs, box, context);
  }

  /// How many references a node at this depth can bring into leaves of the size asked for, by halving alone.
  std::size_t capacity(std::size_t depth) const {
    const Limits& limits = settings_.limits;
    const std::size_t levels = limits.max_depth - depth;
    return levels >= 63 || limits.max_leaf_refs > (std::size_t(-1) >> levels) ? std::size_t(-1)
                                                                              : limits.max_leaf_refs << levels;
  }

 private:
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

  Decision choose(Refs refs, const Box& box, const NodeContext& context) {
    const Limits& limits = settings_.limits;
    const bool too_large = refs.size() > limits.max_leaf_refs;
    if (!too_large && (refs.size() <= limits.leaf_refs || box.side(box.longest_axis()) <= limits.leaf_size)) return {};

    bool over_refs = false;
    const auto allowed = [&](const Candidate& split) {
      if (taken(split.n_left, split.n_right, refs.size()) > context.spare) return !(over_refs = true);
      if (too_large && !parts(split, refs.size())) return false;
      if (context.depth == limits.max_depth) return true;  // looked at below
      return std::max(split.n_left, split.n_right) <= capacity(context.depth + 1);
    };
    const double leaf = lookahead_.cost_of_leaf(refs.size());
    const bool may_be_bad = context.n_bad < settings_.bad_levels && leaf > settings_.cost.c_trav &&
                            (too_large || refs.size() > settings_.bad_refs);
    constexpr double no_limit = std::numeric_limits<double>::infinity();
    typename Lookahead<P>::Found choice;
    bool good = false;
    for (const int lookahead : settings_.lookahead) {
      choice = lookahead_.best_split(refs, box, lookahead, may_be_bad ? no_limit : leaf, allowed);
      good = choice.split && choice.cost < leaf;
      if (good) break;
    }
    limits_hit.refs += over_refs;
    if (context.depth == limits.max_depth) {
      limits_hit.depth += good;
      return {};
    }
    bool forced = !choice.split && too_large;
    // Take what looks least bad, unless that did not help levels above.
    if (forced && context.n_bad == 0)
      choice = lookahead_.best_split(refs, box, settings_.lookahead.front(), no_limit, allowed);
    // Lines that run along each other are only split whole.
    const double min_spread = settings_.min_spread * scene_side_;
    if (choice.split && cuts_retraced(prims_, refs, box, settings_.boxes, *choice.split, min_spread)) {
      choice = lookahead_.best_whole(refs, box, leaf, allowed);
      good = choice.split.has_value();
      forced = !good && too_large;
    }
    limits_hit.leaf_refs += forced;
    // Where nothing divides the node, halve it.
    if (forced && !choice.split)
      Median{}.visit(prims_, refs, box, BoxRule::tight, [&](const Candidate& half) { choice.split = half; });
    const bool refines = !choice.split && context.n_refines < settings_.bad_refines;
    if (refines)
      Midpoint{}.visit(prims_, refs, box, settings_.boxes, [&](const Candidate& split) {
        if (allowed(split)) choice.split = split;
      });
    return {choice.split, good, refines};
  }

  /// Append the subtree of a node; returns its cost.
  double build_node(Buffer<BuildRef>& refs, const Box& box, const NodeContext& context) {
    const std::size_t index = tree.nodes.size(), first_ref = tree.refs.size(), n_refs = refs.size();
    const std::size_t n_empty = n_empty_;
    check_size(index, first_ref + n_refs);
    reserve_more(tree.nodes, 1);
    tree.nodes.push_back({box, 0, std::uint32_t(first_ref), 0});
    auto [split, good, refines] = choose(refs, box, context);
    if (!split) {
      progress_.add(context.share);
      return make_leaf(index, refs);
    }

    // Duplicates are paid out of the spare references; the rest goes to the children by number.
    auto& [left, right] = levels_[context.depth];
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
    if (split->kind == Candidate::Kind::plane && (!Curves<P> || estimates(settings_.splits)) &&
        settings_.boxes == BoxRule::tight) {
      // What was counted plane by plane may be off by some roundings, or a sample's.
      split->left = hull(left);
      split->right = hull(right);
    }
    const std::size_t spare = context.spare - taken(left.size(), right.size(), n_refs);
    const double part = double(left.size()) / double(left.size() + right.size());
    const int n_bad = good ? 0 : context.n_bad + 1, n_refines = context.n_refines + refines;
    const NodeContext in_left{context.depth + 1, std::size_t(double(spare) * part), n_bad, n_refines,
                              context.share * part};
    const NodeContext in_right{context.depth + 1, spare - in_left.spare, n_bad, n_refines,
                               context.share - in_left.share};

    const bool large = std::min(left.size(), right.size()) > kTask;
    const auto [cost_left, cost_right] = large && tasks_.shared()
                                             ? build_side_by_side(index, *split, in_left, in_right)
                                             : build_in_turn(index, *split, in_left, in_right, !large);
    tree.nodes[index].n_refs = std::uint32_t(tree.refs.size() - first_ref);
    const double cost = lookahead_.cost_of(*split, box, cost_left, cost_right);
    if (!may_prune || cost < lookahead_.cost_of_leaf(n_refs)) return cost;
    tree.nodes.resize(index + 1);
    tree.refs.resize(first_ref);
    n_empty_ = n_empty;
    return make_leaf(index, refs);
  }

  /// What the left child leaves of its share of references may be passed on to the right one. Large nodes do not, so
  /// that it can not be seen whether they were built side by side.
  std::pair<double, double> build_in_turn(std::size_t index, const Candidate& split, const NodeContext& in_left,
                                          NodeContext in_right, bool pass_on) {
    auto& [left, right] = levels_[in_left.depth - 1];
    const std::size_t before = n_used(), room = std::max<std::size_t>(left.size(), 1) + in_left.spare;
    const double cost_left = build_node(left, split.left, in_left);
    if (pass_on) in_right.spare += room - (n_used() - before);
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    return {cost_left, build_node(right, split.right, in_right)};
  }

  /// Where somebody takes the right child, it becomes a tree of its own, which is appended when both are finished.
  std::pair<double, double> build_side_by_side(std::size_t index, const Candidate& split, const NodeContext& in_left,
                                               const NodeContext& in_right) {
    auto& [left, right] = levels_[in_left.depth - 1];
    std::optional<NodeBuilder> beside;
    double cost_left, cost_right;
    const auto or_stop = [&](auto&& build) {
      try {
        build();
      } catch (...) {
        tasks_.note(std::current_exception());
        progress_.cancel.store(true);
        throw;
      }
    };
    const bool both = tasks_.side_by_side([&] { or_stop([&] { cost_left = build_node(left, split.left, in_left); }); },
                                          [&] {
                                            or_stop([&] {
                                              beside.emplace(prims_, settings_, progress_, tasks_, scene_side_);
                                              cost_right = beside->build(std::move(right), split.right, in_right);
                                            });
                                          });
    if (!both) {
      tree.nodes[index].right = std::uint32_t(tree.nodes.size());
      return {cost_left, build_node(right, split.right, in_right)};
    }
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    append(tree, beside->tree);
    n_empty_ += beside->n_empty_;
    limits_hit += beside->limits_hit;
    lookahead_.searched += beside->lookahead_.searched;
    return {cost_left, cost_right};
  }

  /// Of the budget: references, and leaves without any.
  std::size_t n_used() const { return tree.refs.size() + n_empty_; }

  double make_leaf(std::size_t index, Refs refs) {
    tree.nodes[index].right = 0;
    tree.nodes[index].n_refs = std::uint32_t(refs.size());
    reserve_more(tree.refs, refs.size());
    for (const BuildRef& ref : refs) tree.refs.push_back(ref.ref);
    n_empty_ += refs.empty();
    return lookahead_.cost_of_leaf(refs.size());
  }

  // With more references than these a child is worth a task, and a node gives its memory to its left child.
  static constexpr std::size_t kTask = 512, kLarge = 1024;

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  TaskGroup& tasks_;
  double scene_side_;  // the longest
  Lookahead<P> lookahead_;
  std::vector<std::pair<Buffer<BuildRef>, Buffer<BuildRef>>> levels_;  // the children of the open nodes
  std::size_t n_empty_ = 0;                                            // leaves without references
};

}  // namespace fastlines
