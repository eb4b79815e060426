// The builder's recursion below one node: search for a split, apply it, continue in the children.
//
// The left child of a large node stays in the memory of its node. The memory behind it takes the right children below
// the left child; that of the whole left child takes those below the right child. So a build takes memory for the
// references of the root and of its right child, and no more unless it cuts many references.
#pragma once

#include <exception>
#include <optional>

#include "../parallel/task_group.hpp"
#include "../splits/retraced_lines.hpp"
#include "../tree/tree.hpp"
#include "free_room.hpp"
#include "lookahead.hpp"

namespace fastlines {

/// A node's place in the tree, and its budget.
struct NodeContext {
  std::size_t depth = 0;  ///< its level; the root's is 0
  std::size_t spare;      ///< the most references that the subtree may have beyond those of the node
  int n_bad = 0;          ///< consecutive bad levels above it
  int n_refines = 0;      ///< bad refines above it
  double share = 1.0;     ///< its fraction of the progress of the build
};

/// Constants of the recursion, in references of a node.
struct NodeBuilderTuning {
  /// Children are built in parallel if both are larger. Smaller tasks would have more overhead.
  std::size_t task_refs = 512;
  /// Larger nodes hand their memory down to their children, which saves copies.
  std::size_t hand_down_refs = 1024;
  /// Memory that is kept for reuse while subtrees of other threads are appended, in bytes.
  std::size_t kept_bytes = std::size_t(1) << 24;
};

/// Builds the subtree of one node, and appends it to `tree`.
template <Primitives P>
class NodeBuilder {
 public:
  /// `scene_side` is the longest side of the scene's box.
  NodeBuilder(const P& prims, const Settings& settings, Progress& progress, TaskGroup& tasks, double scene_side)
      : prims_(prims),
        settings_(settings),
        progress_(progress),
        tasks_(tasks),
        scene_side_(scene_side),
        lookahead_(prims, settings, progress, settings.radius_hint * scene_side) {}

  Tree tree;
  LimitsHit limits_hit;

  const SearchCounts& search_counts() const { return lookahead_.search_counts; }

  /// Build the subtree of a node with these references. Returns its cost.
  double build(Buffer<BuildRef> refs, const Box& box, const NodeContext& context) {
    levels_.resize(settings_.limits.max_depth + 1);
    // Reserve as much as many trees need: growing would copy, and unused pages cost no memory.
    const std::size_t more = std::min(context.spare, 3 * refs.size());
    tree.nodes.reserve(refs.size());
    tree.refs.reserve(refs.size() + more);
    auto all = Buffer<BuildRef>::within({refs.data(), refs.capacity()});
    all.set_size(refs.size());
    return build_node(all, box, context);
  }

  /// The most references of a node at this depth that halving alone can bring into leaves of `max_leaf_refs`.
  std::size_t capacity(std::size_t depth) const {
    const Limits& limits = settings_.limits;
    const std::size_t levels = limits.max_depth - depth;
    return levels >= 63 || limits.max_leaf_refs > (std::size_t(-1) >> levels) ? std::size_t(-1)
                                                                              : limits.max_leaf_refs << levels;
  }

 private:
  /// The spare references that a split uses: one for each duplicate and for each empty child. Counting empty children
  /// bounds the number of nodes as well.
  static std::size_t spare_used(std::size_t n_left, std::size_t n_right, std::size_t n_refs) {
    return n_left + n_right - n_refs + (n_left == 0) + (n_right == 0);
  }

  /// Whether a child is smaller than its node. Lines that lie on top of each other can be cut but not separated: every
  /// cut would look profitable, and no leaf would become small.
  static bool separates(const Candidate& split, std::size_t n_refs) {
    return split.n_left < n_refs || split.n_right < n_refs;
  }

  struct Decision {
    std::optional<Candidate> split;  // none for a leaf
    bool good = false;               // the search found the split cheaper than a leaf
    bool refines = false;            // the split refines a node for which the search chose a leaf
  };

  /// Decide whether to split a node, and how.
  Decision choose(Refs refs, const Box& box, const NodeContext& context) {
    const Limits& limits = settings_.limits;
    const bool too_large = refs.size() > limits.max_leaf_refs;
    if (!too_large && (refs.size() <= limits.leaf_refs || box.side(box.longest_axis()) <= limits.leaf_size)) return {};

    bool over_refs = false;
    const auto allowed = [&](const Candidate& split) {
      if (spare_used(split.n_left, split.n_right, refs.size()) > context.spare) return !(over_refs = true);
      if (too_large && !separates(split, refs.size())) return false;
      if (context.depth == limits.max_depth) return true;  // handled below
      return std::max(split.n_left, split.n_right) <= capacity(context.depth + 1);
    };
    // Search, with more levels while the search finds no profitable split.
    const double leaf = lookahead_.cost_of_leaf(refs.size());
    const bool may_be_bad = context.n_bad < settings_.bad_levels && leaf > settings_.cost.c_trav &&
                            (too_large || refs.size() > settings_.bad_refs);
    typename Lookahead<P>::Choice choice;
    bool good = false;
    for (const int lookahead : settings_.lookahead) {
      choice = lookahead_.best_split(refs, box, lookahead, may_be_bad ? kInfinity : leaf, allowed);
      good = choice.split && choice.cost < leaf;
      if (good) break;
    }
    limits_hit.refs += over_refs;
    if (context.depth == limits.max_depth) {
      limits_hit.depth += good;
      return {};
    }
    // Too large for a leaf: take the least bad split, unless the level above already took a bad one.
    bool forced = !choice.split && too_large;
    if (forced && context.n_bad == 0)
      choice = lookahead_.best_split(refs, box, settings_.lookahead.front(), kInfinity, allowed);
    // Split retraced lines only uncut.
    const double min_spread = settings_.min_spread * scene_side_;
    if (choice.split && cuts_retraced(prims_, refs, box, settings_.boxes, *choice.split, min_spread)) {
      choice = lookahead_.best_uncut(refs, box, leaf, allowed);
      good = choice.split.has_value();
      forced = !good && too_large;
    }
    limits_hit.leaf_refs += forced;
    // Halve the node where no split divides it.
    if (forced && !choice.split)
      Median{}.visit(prims_, refs, box, BoxRule::tight, [&](const Candidate& half) { choice.split = half; });
    // Refine at the midpoint.
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

    // Move the references to the children.
    auto& [left, right] = levels_[context.depth];
    const bool may_prune = settings_.prune && n_refs <= settings_.limits.max_leaf_refs;
    const bool in_place = n_refs > kTuning.hand_down_refs && !may_prune;
    Buffer<BuildRef> block;  // for the right child, if there is no other room
    FreeRoom::Part room;
    if (in_place) {
      left = std::move(refs);
      room = free_room_.take(split->n_right + 1);
      right = Buffer<BuildRef>::within(
          room.part.empty() ? std::span(block.reset(split->n_right + 1), split->n_right + 1) : room.part);
    }
    const std::span<BuildRef> of_node(in_place ? left.data() : nullptr, in_place ? n_refs : 0);
    partition(prims_, in_place ? left : refs, *split, left, right);
    if (split->kind == Candidate::Kind::plane && (!Curves<P> || estimates(settings_.splits)) &&
        settings_.boxes == BoxRule::tight) {
      // The candidate's boxes may be off by rounding, or bound only a sample.
      split->left = hull(left);
      split->right = hull(right);
    }
    // Take duplicates from the spare references, and divide the rest in proportion to the children's references.
    const std::size_t spare = context.spare - spare_used(left.size(), right.size(), n_refs);
    const double part = double(left.size()) / double(left.size() + right.size());
    const int n_bad = good ? 0 : context.n_bad + 1, n_refines = context.n_refines + refines;
    const NodeContext in_left{context.depth + 1, std::size_t(double(spare) * part), n_bad, n_refines,
                              context.share * part};
    const NodeContext in_right{context.depth + 1, spare - in_left.spare, n_bad, n_refines,
                               context.share - in_left.share};

    // Build the children.
    const bool large = std::min(left.size(), right.size()) > kTuning.task_refs;
    const auto [cost_left, cost_right] = large && tasks_.is_parallel()
                                             ? build_in_parallel(index, *split, in_left, in_right, of_node)
                                             : build_in_turn(index, *split, in_left, in_right, of_node, !large);
    if (in_place) {
      left = {};
      right = {};
      free_room_.give_back(room);
      // Nodes below the root seldom need a block, and hardly ever one of the same size.
      if (context.depth > 0 && block.data()) PagePool::trim(block.data(), 0);
    }
    tree.nodes[index].n_refs = std::uint32_t(tree.refs.size() - first_ref);
    const double cost = lookahead_.cost_of(*split, box, cost_left, cost_right);
    // Prune the subtree if it costs no less than a leaf.
    if (!may_prune || cost < lookahead_.cost_of_leaf(n_refs)) return cost;
    tree.nodes.resize(index + 1);
    tree.refs.resize(first_ref);
    n_empty_ = n_empty;
    return make_leaf(index, refs);
  }

  /// Build the left child, then the right one. `of_node` is the memory of a large node, else empty. With `pass_on`, the
  /// right child inherits the spare references that the left one did not use. Large children never do: then the tree
  /// does not depend on whether they are built in parallel.
  std::pair<double, double> build_in_turn(std::size_t index, const Candidate& split, const NodeContext& in_left,
                                          NodeContext in_right, std::span<BuildRef> of_node, bool pass_on) {
    const std::size_t n_left = levels_[in_left.depth - 1].first.size();
    const std::size_t used_before = n_used(), room = std::max<std::size_t>(n_left, 1) + in_left.spare;
    const double cost_left = build_left(split, in_left, of_node);
    if (pass_on) in_right.spare += room - (n_used() - used_before);
    return {cost_left, build_right(index, split, in_right, of_node)};
  }

  /// Build the left child of a node; the memory behind it is free.
  double build_left(const Candidate& split, const NodeContext& in_left, std::span<BuildRef> of_node) {
    auto& left = levels_[in_left.depth - 1].first;
    const FreeRoom::More more(free_room_, of_node.subspan(std::min(left.size(), of_node.size())), left.size());
    return build_node(left, split.left, in_left);
  }

  /// Build the right child of a node after the left one, whose memory is free.
  double build_right(std::size_t index, const Candidate& split, const NodeContext& in_right,
                     std::span<BuildRef> of_node) {
    auto& right = levels_[in_right.depth - 1].second;
    const FreeRoom::More more(free_room_, of_node, right.size());
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    return build_node(right, split.right, in_right);
  }

  /// Build both children in parallel. If another thread takes the right child, that child becomes a tree of its own,
  /// which is appended when both are finished.
  std::pair<double, double> build_in_parallel(std::size_t index, const Candidate& split, const NodeContext& in_left,
                                              const NodeContext& in_right, std::span<BuildRef> of_node) {
    std::optional<NodeBuilder> right_builder;
    double cost_left, cost_right;
    const auto or_cancel = [&](auto&& build) {
      try {
        build();
      } catch (...) {
        tasks_.keep_error(std::current_exception());
        progress_.cancel.store(true);
        throw;
      }
    };
    const bool was_taken = tasks_.fork_join(
        [&] { or_cancel([&] { cost_left = build_left(split, in_left, of_node); }); },
        [&] {
          or_cancel([&] {
            right_builder.emplace(prims_, settings_, progress_, tasks_, scene_side_);
            cost_right = right_builder->build(std::move(levels_[in_right.depth - 1].second), split.right, in_right);
          });
        });
    if (!was_taken) return {cost_left, build_right(index, split, in_right, of_node)};
    tree.nodes[index].right = std::uint32_t(tree.nodes.size());
    append(tree, std::move(right_builder->tree));
    PagePool::shrink(kTuning.kept_bytes);
    n_empty_ += right_builder->n_empty_;
    limits_hit += right_builder->limits_hit;
    lookahead_.search_counts += right_builder->lookahead_.search_counts;
    return {cost_left, cost_right};
  }

  /// How much of the budget is used: references, and one for each empty leaf.
  std::size_t n_used() const { return tree.refs.size() + n_empty_; }

  /// Turn the node into a leaf; returns its cost.
  double make_leaf(std::size_t index, Refs refs) {
    tree.nodes[index].right = 0;
    tree.nodes[index].n_refs = std::uint32_t(refs.size());
    reserve_more(tree.refs, refs.size());
    for (const BuildRef& ref : refs) tree.refs.push_back(ref.ref);
    n_empty_ += refs.empty();
    return lookahead_.cost_of_leaf(refs.size());
  }

  static constexpr NodeBuilderTuning kTuning{};

  const P& prims_;
  const Settings& settings_;
  Progress& progress_;
  TaskGroup& tasks_;
  double scene_side_;  // the longest side of the scene's box
  Lookahead<P> lookahead_;
  // References of the children of open nodes, by depth.
  std::vector<std::pair<Buffer<BuildRef>, Buffer<BuildRef>>> levels_;
  FreeRoom free_room_;
  std::size_t n_empty_ = 0;  // leaves without references
};

}  // namespace fastlines
