// Plans which nodes of a binary tree become children of which wide node, at least cost. Uses dynamic programming
// (Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs").
//
// C(v, i) is the least cost of the subtree of v as at most i children of one wide node:
//
//     C(v, 1) = min( SA(v)·c_leaf  if at most 16 references lie below v,   SA(v)·c_node + D(v, 16) )
//     C(v, i) = min( C(v, i − 1),  D(v, i) )
//     D(v, i) = min over 1 ≤ k < i of  C(left, k) + C(right, i − k)
//
// Children have larger indices than their parents, so a backward loop fills the table: first for separate subtrees, in
// parallel, then for the nodes above them. The costs of nodes whose parents are still to come are a stack, as the nodes
// are in preorder; no other costs are kept.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "../memory/buffer.hpp"
#include "../parallel/parallel_for.hpp"
#include "../tree/subtree_ranges.hpp"
#include "merge_pieces.hpp"

namespace fastlines {

/// The cost model of a collapse.
struct CollapseCost {
  float c_node = 1.2f;       ///< of culling a node; only its ratio to c_leaf matters
  float c_leaf = 1.0f;       ///< of culling a leaf
  double radius_hint = 0.0;  ///< boxes are measured grown by this fraction of the scene's longest side
};

/// The best way to split a subtree into at most i children of a wide node.
struct CollapsePlan {
  std::uint8_t k[kSimdWidth + 1];  ///< the left subtree gets k[i] of i children; 0: the plan is that of i − 1
  std::uint8_t k_all;              ///< the k of D(v, 16), if v becomes a wide node
  std::uint8_t n_leaves;           ///< leaves below v, at most 16: more children are useless
  bool leaf;                       ///< whether v becomes a leaf if it is one child
};

/// Computes the plan of each node.
class CollapsePlanner {
 public:
  CollapsePlanner(std::span<const Node> nodes, std::span<const Reference> refs, const CollapseCost& cost)
      : nodes_(nodes), refs_(refs), cost_(cost) {
    const Box& box = nodes[0].box;
    margin_ = cost.radius_hint * box.side(box.longest_axis());
    root_area_ = std::max(box.area(margin_), 1e-300);
  }

  Buffer<CollapsePlan> operator()(unsigned n_threads, Progress& progress) {
    plans_.reset(nodes_.size());
    const SubtreeRanges ranges = subtree_ranges(nodes_, kMaxTaskNodes, std::numeric_limits<std::size_t>::max());
    std::vector<Costs> of_below(ranges.below.size());
    parallel_for(
        ranges.below.size(), n_threads, progress, [] { return std::vector<Costs>(); },
        [&](std::vector<Costs>& stack, std::size_t i) {
          for (std::uint32_t v = ranges.below[i].end; v-- > ranges.below[i].begin;) plan(v, stack);
          of_below[i] = stack.back();
          stack.clear();
        },
        {0.0, 0.4});
    std::vector<Costs> stack;
    for (std::size_t i = ranges.below.size(), j = ranges.above.size(); i + j > 0;) {
      if (i > 0 && (j == 0 || ranges.below[i - 1].begin > ranges.above[j - 1]))
        stack.push_back(of_below[--i]);
      else
        plan(ranges.above[--j], stack);
    }
    plans_.set_size(nodes_.size());
    return std::move(plans_);
  }

 private:
  /// The most nodes in a subtree that is a task of its own.
  static constexpr std::uint32_t kMaxTaskNodes = 4096;

  /// C(v, i + 1) of a node, for each i.
  struct Costs {
    float of[kSimdWidth];
  };

  /// Plan node v. The costs of its left child are on top of the stack, above those of its right child. Those of v
  /// replace both.
  void plan(std::uint32_t v, std::vector<Costs>& stack) {
    const Node& node = nodes_[v];
    CollapsePlan& plan = plans_[v];
    const auto area = float(node.box.area(margin_) / root_area_);
    const float as_leaf = fits_leaf(refs_.subspan(node.first_ref, node.n_refs)) ? area * cost_.c_leaf : kInfinity;
    std::fill(std::begin(plan.k), std::end(plan.k), std::uint8_t(0));
    plan.k_all = 0;
    plan.n_leaves = 1;
    plan.leaf = node.is_leaf();
    if (node.is_leaf()) {
      std::ranges::fill(stack.emplace_back().of, as_leaf);
      return;
    }

    // Compute D(v, i + 1) in lane i: for each k, shift the costs of the right child by k lanes.
    const Costs left = stack.back(), &right = stack[stack.size() - 2];
    const int n_left = plans_[v + 1].n_leaves;
    plan.n_leaves = std::uint8_t(std::min(n_left + plans_[node.right].n_leaves, kSimdWidth));
    alignas(64) float shifted[2 * kSimdWidth], least[kSimdWidth], best_k[kSimdWidth];
    std::fill_n(shifted, kSimdWidth, kInfinity);
    std::copy_n(right.of, kSimdWidth, shifted + kSimdWidth);
    FloatX16 costs = kInfinity, ks = 0.0f;
    for (int k = 1; k <= std::min(n_left, kSimdWidth - 1); ++k) {
      const FloatX16 cost = FloatX16(left.of[k - 1]) + FloatX16::load(shifted + kSimdWidth - k);
      const MaskX16 less = cost < costs;
      costs = blend(less, cost, costs);
      ks = blend(less, FloatX16(float(k)), ks);
    }
    costs.store(least);
    ks.store(best_k);
    plan.k_all = std::uint8_t(best_k[kSimdWidth - 1]);
    const float as_node = area * cost_.c_node + least[kSimdWidth - 1];
    plan.leaf = as_leaf <= as_node;
    stack.pop_back();
    float* const cost = stack.back().of;
    cost[0] = min(as_leaf, as_node);
    for (int i = 1; i < plan.n_leaves; ++i) {
      cost[i] = min(least[i], cost[i - 1]);
      plan.k[i + 1] = least[i] < cost[i - 1] ? std::uint8_t(best_k[i]) : std::uint8_t(0);
    }
    std::fill(cost + plan.n_leaves, cost + kSimdWidth, cost[plan.n_leaves - 1]);
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  CollapseCost cost_;
  double margin_, root_area_;
  Buffer<CollapsePlan> plans_;
};

}  // namespace fastlines
