// From a binary tree to a wide one, at least cost (Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal on
// GPUs through compressed wide BVHs").
//
// C(v, i) = least cost of the subtree of v as at most i children of one wide node:
//
//     C(v, 1) = the less of  SA(v)·c_leaf         if at most 16 references lie below v
//                       and  SA(v)·c_node + D(v, 16)
//     C(v, i) = the less of  C(v, i − 1)  and  D(v, i)
//     D(v, i) = min over 1 ≤ k < i of  C(left, k) + C(right, i − k)
//
// Children have larger indices than their parents, so one loop backwards fills the table. Nothing is lost: every
// reference of the tree is in a leaf, and adjacent pieces of one segment that meet in a leaf become one.
#pragma once

#include <cmath>
#include <cstring>
#include <span>

#include "../build/progress.hpp"
#include "divide.hpp"
#include "fit.hpp"

namespace fastlines {

struct CollapseCost {
  float c_node = 1.2f, c_leaf = 1.0f;
  double radius_hint = 0.0;  ///< boxes are measured grown by this much of the scene's longest side
};

class Collapse {
 public:
  Collapse(std::span<const Node> nodes, std::span<const Reference> refs, std::span<const Segment> segments,
           const CollapseCost& cost, Progress& progress)
      : nodes_(nodes), refs_(refs), segments_(segments), cost_(cost), progress_(progress) {
    const Box& box = nodes[0].box;
    margin_ = cost.radius_hint * box.side(box.longest_axis());
  }

  WideTree operator()() {
    wide_.frame = frame_of(nodes_[0].box);
    fill_table();
    wide_.nodes.emplace_back();
    if (plans_[0].leaf) {
      // A root that is a leaf becomes the one child of a node.
      wide_.nodes[0].n_children = 1;
      wide_.leaves.emplace_back();
      list_pieces(0, 0);
    } else {
      emit(0, 0);
    }
    wide_.box = {wide_.frame(nodes_[0].box.lo), wide_.frame(nodes_[0].box.hi)};
    wide_.mean_extent = Fit(wide_.frame, wide_.nodes, wide_.leaves, wide_.refs, segments_, wide_.nodes.data(),
                            wide_.leaves.data())(1, progress_);
    return std::move(wide_);
  }

 private:
  /// How a subtree is best spread over i children: k[i] go to the left one; 0 = as for i − 1.
  struct Plan {
    float cost[kWidth];  // C(v, i + 1)
    std::uint8_t k[kWidth + 1];
    std::uint8_t k_all;  // of D(v, 16), for v as a node of its own
    bool leaf;
  };

  void fill_table() {
    plans_.resize(nodes_.size());
    const double root_area = std::max(nodes_[0].box.area(margin_), 1e-300);
    for (std::size_t v = nodes_.size(); v-- > 0;) {
      if (v % 1024 == 0) progress_.check();
      const Node& node = nodes_[v];
      Plan& plan = plans_[v];
      const auto area = float(node.box.area(margin_) / root_area);
      const float as_leaf = fits(node) ? area * cost_.c_leaf : INFINITY;
      std::memset(plan.k, 0, sizeof plan.k);
      plan.k_all = 0;
      plan.leaf = node.is_leaf();
      if (node.is_leaf()) {
        for (float& cost : plan.cost) cost = as_leaf;
        continue;
      }
      const Plan &left = plans_[v + 1], &right = plans_[node.right];
      float least[kWidth + 1];
      for (int i = 2; i <= kWidth; ++i) {
        least[i] = INFINITY;
        for (int k = 1; k < i; ++k) {
          const float cost = left.cost[k - 1] + right.cost[i - k - 1];
          if (cost < least[i]) {
            least[i] = cost;
            plan.k[i] = std::uint8_t(k);
          }
        }
      }
      plan.k_all = plan.k[kWidth];
      const float as_node = area * cost_.c_node + least[kWidth];
      plan.leaf = as_leaf <= as_node;
      plan.cost[0] = std::min(as_leaf, as_node);
      for (int i = 2; i <= kWidth; ++i) {
        plan.cost[i - 1] = std::min(plan.cost[i - 2], least[i]);
        if (plan.cost[i - 2] <= least[i]) plan.k[i] = 0;
      }
    }
  }

  /// The subtrees that become the children of one node.
  void list(std::uint32_t v, int i, std::vector<std::uint32_t>& children) const {
    while (i > 1 && plans_[v].k[i] == 0) --i;
    if (i == 1) {
      children.push_back(v);
      return;
    }
    const int k = plans_[v].k[i];
    list(v + 1, k, children);
    list(nodes_[v].right, i - k, children);
  }

  void emit(std::uint32_t v, std::size_t index) {
    std::vector<std::uint32_t> children;
    const int k = plans_[v].k_all;
    list(v + 1, k, children);
    list(nodes_[v].right, kWidth - k, children);
    const auto first_leaf_child = std::stable_partition(children.begin(), children.end(),
                                                        [&](std::uint32_t child) { return !plans_[child].leaf; });
    const auto n_inner = std::size_t(first_leaf_child - children.begin());
    const std::size_t first_inner = wide_.nodes.size(), first_leaf = wide_.leaves.size();
    wide_.nodes.resize(first_inner + n_inner);
    wide_.leaves.resize(first_leaf + children.size() - n_inner);
    WideNode& node = wide_.nodes[index];
    node.first_inner = std::uint32_t(first_inner);
    node.first_leaf = std::uint32_t(first_leaf);
    node.n_inner = std::uint8_t(n_inner);
    node.n_children = std::uint8_t(children.size());
    for (std::size_t i = n_inner; i < children.size(); ++i) list_pieces(children[i], first_leaf + i - n_inner);
    for (std::size_t i = 0; i < n_inner; ++i) emit(children[i], first_inner + i);
  }

  void list_pieces(std::uint32_t v, std::size_t index) {
    merge(nodes_[v]);
    wide_.leaves[index].first_ref = std::uint32_t(wide_.refs.size());
    wide_.leaves[index].n_refs = std::uint32_t(merged_.size());
    wide_.refs.insert(wide_.refs.end(), merged_.begin(), merged_.end());
  }

  /// The references below a node, adjacent pieces of one segment joined.
  void merge(const Node& node) const {
    const auto below = refs_.subspan(node.first_ref, node.n_refs);
    merged_.assign(below.begin(), below.end());
    std::sort(merged_.begin(), merged_.end(),
              [](const Reference& a, const Reference& b) { return a.prim != b.prim ? a.prim < b.prim : a.s0 < b.s0; });
    std::size_t n = 0;
    for (const Reference& ref : merged_)
      if (n > 0 && merged_[n - 1].prim == ref.prim && merged_[n - 1].s1 == ref.s0)
        merged_[n - 1].s1 = ref.s1;
      else
        merged_[n++] = ref;
    merged_.resize(n);
  }

  /// Whether the references below a node are few once adjacent pieces are joined. Most nodes have too many segments for
  /// that, which is soon seen.
  bool fits(const Node& node) const {
    if (node.n_refs <= kWidth) return true;
    if (node.n_refs > 8 * kWidth) return false;
    std::uint32_t seen[kWidth];
    int n_seen = 0;
    for (const Reference& ref : refs_.subspan(node.first_ref, node.n_refs)) {
      if (std::find(seen, seen + n_seen, ref.prim) != seen + n_seen) continue;
      if (n_seen == kWidth) return false;
      seen[n_seen++] = ref.prim;
    }
    merge(node);
    return merged_.size() <= kWidth;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  std::span<const Segment> segments_;
  CollapseCost cost_;
  Progress& progress_;
  double margin_;
  LargeVector<Plan> plans_;
  mutable std::vector<Reference> merged_;
  WideTree wide_;
};

inline WideTree collapse(std::span<const Node> nodes, std::span<const Reference> refs,
                         std::span<const Segment> segments, const CollapseCost& cost, Progress& progress) {
  const auto too_large = [](const Node& node) { return node.is_leaf() && node.n_refs > kWidth; };
  if (std::none_of(nodes.begin(), nodes.end(), too_large)) return Collapse(nodes, refs, segments, cost, progress)();
  const Tree tree = divide_leaves(nodes, refs, segments, kWidth);
  return Collapse(tree.nodes, tree.refs, segments, cost, progress)();
}

}  // namespace fastlines
