// Insertion-based optimisation (Bittner, Hapala, Havran 2013, "Fast insertion-based optimization of bounding volume
// hierarchies"; in parallel as Meister, Bittner 2018, "Parallel reinsertion for bounding volume hierarchy
// optimization"). Subtrees of a finished BVH are removed and reinserted where they cost least.
//
// Leaves stay as they are, and the root's box does not change. So of the cost g (thesis §3.3) only the sum of the areas
// of the inner nodes changes, and c_trav and c_prim need not be known. Moving v next to x gains
//
//     SA(parent of v) − SA(x ∪ v) + Σ_a (SA(a) − SA(a without v)) − Σ_y (SA(y ∪ v) − SA(y))
//
// where a are the ancestors of v's parent, and y those of x, both below the node where the two paths to the root meet.
// If x is itself an ancestor of v, it is one of the a, and x ∪ v is its box.
//
// A round first finds the best move of every node, in parallel, by branch and bound: below a node that v would grow, no
// move gains more than the gain so far less SA(v). It then makes the moves one by one, in order of decreasing gain.
// Earlier moves have changed the tree, so each gain is computed again, and moves that no longer gain are skipped. So no
// round increases the tree's cost, and the result does not depend on the number of threads.
#pragma once

#include <array>
#include <span>

#include "../parallel/parallel_for.hpp"
#include "../tree/tree.hpp"

namespace fastlines {

/// Optimises one tree. Call it once; the result owns its memory.
class Reinsertion {
 public:
  struct Options {
    int rounds = 1;              ///< at most; the first round without a move is the last
    std::size_t max_depth = 64;  ///< no move places a node deeper than this level
    double radius_hint = 0.0;    ///< boxes are measured grown by this fraction of the scene's longest side
    unsigned n_threads = 1;      ///< the result does not depend on it
  };

  Reinsertion(std::span<const Node> nodes, std::span<const Reference> refs, const Options& options, Progress& progress)
      : nodes_(nodes), refs_(refs), options_(options), progress_(progress), links_(nodes.size()) {
    const Box& box = nodes[0].box;
    margin_ = options.radius_hint * box.side(box.longest_axis());
    min_gain_ = 1e-9 * area_of(box);
    for (std::uint32_t v = std::uint32_t(nodes.size()); v-- > 0;) {
      links_[v].box = nodes[v].box;
      links_[v].area = area_of(nodes[v].box);
      if (nodes[v].is_leaf()) continue;
      links_[v].child = {v + 1, nodes[v].right};
      for (const std::uint32_t child : links_[v].child) links_[child].parent = v;
      links_[v].height = height_of(v);
    }
  }

  Tree operator()() {
    for (int round = 0; round < options_.rounds; ++round)
      if (!improve({double(round) / options_.rounds, double(round + 1) / options_.rounds})) break;
    tree_.nodes.reserve(nodes_.size());
    tree_.refs.reserve(refs_.size());
    list_nodes();
    return std::move(tree_);
  }

  /// How many moves were refused because of max_depth.
  std::size_t n_too_deep() const { return n_too_deep_; }

 private:
  /// A node with links to its parent and children, so that it can be moved.
  struct LinkedNode {
    Box box;
    double area;
    std::uint32_t parent = kNoNode;
    std::array<std::uint32_t, 2> child{kNoNode, kNoNode};
    std::uint32_t height = 0;  // of the subtree, in levels below it

    bool is_leaf() const { return child[0] == kNoNode; }
  };

  /// Make v and x siblings.
  struct Move {
    double gain;
    std::uint32_t v, x;
  };

  /// A subtree to search, and the gain before any of its nodes grows.
  struct Pending {
    std::uint32_t x;
    double gain;
  };

  double area_of(const Box& box) const { return box.area(margin_); }

  double area_of(const Box& a, const Box& b) const {
    Box both = a;
    both.grow(b);
    return area_of(both);
  }

  std::uint32_t height_of(std::uint32_t v) const {
    const auto& [left, right] = links_[v].child;
    return 1 + std::max(links_[left].height, links_[right].height);
  }

  std::uint32_t sibling(std::uint32_t v) const {
    const auto& child = links_[links_[v].parent].child;
    return child[child[0] == v];
  }

  /// One round; returns whether it made a move.
  bool improve(Stage stage) {
    constexpr std::size_t chunk_size = 256;  // nodes
    std::vector<Move> moves(links_.size());
    parallel_for_chunks(
        links_.size(), chunk_size, options_.n_threads, progress_, [] { return std::vector<Pending>{}; },
        [&](std::vector<Pending>& pending, std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            progress_.check();
            moves[v] = best_move(std::uint32_t(v), pending);
          }
        },
        stage);
    std::erase_if(moves, [](const Move& move) { return move.x == kNoNode; });
    std::sort(moves.begin(), moves.end(),
              [](const Move& a, const Move& b) { return a.gain != b.gain ? a.gain > b.gain : a.v < b.v; });
    std::size_t n_applied = 0;
    for (const Move& move : moves) {
      progress_.check();
      n_applied += apply(move.v, move.x);
    }
    return n_applied > 0;
  }

  /// The move of v that gains most; x is kNoNode if no move gains.
  Move best_move(std::uint32_t v, std::vector<Pending>& pending) const {
    Move best{min_gain_, v, kNoNode};
    if (v == root_) return best;
    const Box box = links_[v].box;
    const double area = links_[v].area;
    const std::uint32_t parent = links_[v].parent;
    double gain = links_[parent].area;     // of removing v, from the nodes below the pivot
    Box without = links_[sibling(v)].box;  // the pivot without v
    for (std::uint32_t below = v, pivot = parent; pivot != kNoNode; below = pivot, pivot = links_[pivot].parent) {
      const std::uint32_t other = sibling(below);

      // Search the subtree on the other side of the pivot.
      pending.push_back({other, gain});
      while (!pending.empty()) {
        const auto [x, gain_so_far] = pending.back();
        pending.pop_back();
        if (gain_so_far - area <= best.gain) continue;
        const double gain_here = gain_so_far - area_of(links_[x].box, box);
        if (gain_here > best.gain) best = {gain_here, v, x};
        if (links_[x].is_leaf()) continue;
        const double gain_below = gain_here + links_[x].area;
        if (gain_below - area > best.gain)
          for (const std::uint32_t child : links_[x].child) pending.push_back({child, gain_below});
      }

      // Try the pivot itself.
      if (pivot == parent) continue;
      without.grow(links_[other].box);
      const double above = gain - area_of(without);
      if (above > best.gain) best = {above, v, pivot};
      gain = above + links_[pivot].area;
    }
    return best;
  }

  std::uint32_t depth_of(std::uint32_t v) const {
    std::uint32_t depth = 0;
    while ((v = links_[v].parent) != kNoNode) ++depth;
    return depth;
  }

  /// Make v and x siblings, if that gains in the tree as it is now. Returns whether it did.
  bool apply(std::uint32_t v, std::uint32_t x) {
    // Find the node where the two paths to the root meet: the pivot.
    const std::uint32_t parent = links_[v].parent;
    if (parent == kNoNode) return false;
    const std::uint32_t depth_v = depth_of(v), depth_x = depth_of(x);
    std::uint32_t a = v, pivot = x;
    for (std::uint32_t depth = depth_v; depth > depth_x; --depth) a = links_[a].parent;
    for (std::uint32_t depth = depth_x; depth > depth_v; --depth) pivot = links_[pivot].parent;
    for (; pivot != a; a = links_[a].parent) pivot = links_[pivot].parent;
    if (pivot == v || x == parent) return false;

    // Measure the gain.
    const Box& box = links_[v].box;
    double gain = links_[parent].area - area_of(links_[x].box, box);
    if (x != pivot)
      for (std::uint32_t y = links_[x].parent; y != pivot; y = links_[y].parent)
        gain -= area_of(links_[y].box, box) - links_[y].area;
    Box without = links_[sibling(v)].box;
    for (a = parent; a != pivot;) {
      without.grow(links_[sibling(a)].box);
      a = links_[a].parent;
      if (a != pivot || a == x) gain += links_[a].area - area_of(without);
    }
    if (gain <= min_gain_) return false;
    const std::size_t deepest = depth_x + (pivot != parent) + std::max(links_[x].height, links_[v].height);
    if (deepest > options_.max_depth) {
      ++n_too_deep_;
      return false;
    }

    // Remove v and its parent, and insert the parent above x.
    const std::uint32_t grandparent = links_[parent].parent;
    replace(grandparent, parent, sibling(v));
    replace(links_[x].parent, x, parent);
    links_[parent].child[links_[parent].child[0] == v] = x;
    links_[x].parent = parent;
    refit(grandparent);
    refit(parent);
    return true;
  }

  /// Make `other` the child of `parent` instead of `child`; without a parent, make it the root.
  void replace(std::uint32_t parent, std::uint32_t child, std::uint32_t other) {
    if (parent == kNoNode)
      root_ = other;
    else
      links_[parent].child[links_[parent].child[1] == child] = other;
    links_[other].parent = parent;
  }

  /// Recompute the boxes, areas and heights of a node and its ancestors.
  void refit(std::uint32_t v) {
    for (; v != kNoNode; v = links_[v].parent) {
      LinkedNode& link = links_[v];
      link.box = links_[link.child[0]].box;
      link.box.grow(links_[link.child[1]].box);
      link.area = area_of(link.box);
      link.height = height_of(v);
    }
  }

  /// List the nodes of the final tree in preorder.
  void list_nodes() {
    struct Entry {
      std::uint32_t v, parent;  // parent: index in the list if v is a right child, else kNoNode
    };
    std::vector<Entry> pending{{root_, kNoNode}};
    while (!pending.empty()) {
      const auto [v, parent] = pending.back();
      pending.pop_back();
      const auto index = std::uint32_t(tree_.nodes.size());
      if (parent != kNoNode) tree_.nodes[parent].right = index;
      tree_.nodes.push_back({links_[v].box, 0, std::uint32_t(tree_.refs.size()), 0});
      if (links_[v].is_leaf()) {
        const auto refs = refs_.subspan(nodes_[v].first_ref, nodes_[v].n_refs);
        tree_.refs.insert(tree_.refs.end(), refs.begin(), refs.end());
        tree_.nodes[index].n_refs = nodes_[v].n_refs;
      } else {
        pending.push_back({links_[v].child[1], index});
        pending.push_back({links_[v].child[0], kNoNode});
      }
    }
    for (std::size_t i = tree_.nodes.size(); i-- > 0;)
      if (Node& node = tree_.nodes[i]; !node.is_leaf())
        node.n_refs = tree_.nodes[i + 1].n_refs + tree_.nodes[node.right].n_refs;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  Options options_;
  Progress& progress_;
  std::vector<LinkedNode> links_;
  std::uint32_t root_ = 0;
  double margin_ = 0.0;    // by which boxes are grown before they are measured
  double min_gain_ = 0.0;  // moves that gain no more are skipped
  std::size_t n_too_deep_ = 0;
  Tree tree_;
};

}  // namespace fastlines
