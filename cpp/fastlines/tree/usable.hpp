// Checks all that queries, layouts and refits rely on in a tree. The time is linear in its size; a primitive without
// pieces in k leaves takes about k·log k.
//
//   - The tree is binary, in preorder, and no deeper than kMaxDepth. Its leaves list each reference once (axioms 1, 2).
//   - Boxes are finite and not empty (axiom 2), they are nested (axiom 4), and the root's box bounds all primitives
//     (axiom 3). In a KD tree the children's boxes cut their parent's in two.
//   - Pieces tile their primitives and lie in the boxes of their leaves. Primitives without pieces are covered by the
//     leaves that list them (what remains of axiom 5).
//
// The axioms are those of thesis §3.2; `Validator` checks the rest of them.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "../parallel/progress.hpp"
#include "../primitives/segments.hpp"
#include "../references/slack.hpp"
#include "../splits/box_rule.hpp"
#include "coverage.hpp"
#include "tree.hpp"

namespace fastlines {

/// What is wrong with a tree, and where.
struct Violation {
  std::size_t node;    ///< index of the node
  std::string axiom;   ///< the axiom, theorem or bound that is violated
  std::string detail;  ///< a sentence about that node
};

/// Checks one tree; the references to its data must stay valid.
template <Primitives P>
class Usable {
 public:
  using Nodes = std::span<const Node>;
  using References = std::span<const Reference>;

  Usable(const P& prims, Nodes nodes, References refs, BoxRule rule, const Progress& progress)
      : prims_(prims), nodes_(nodes), refs_(refs), rule_(rule), progress_(progress) {}

  /// The first violation found, if there is one.
  std::optional<Violation> operator()() {
    check_graph() && check_references() && check_root() && check_boxes() && check_pieces();
    return found_;
  }

 protected:
  /// Record a violation; returns false.
  bool fail(std::size_t node, const char* axiom, std::string detail) {
    found_ = Violation{node, axiom, std::move(detail)};
    return false;
  }

  /// Check for cancellation at every 4096th i.
  void check_cancelled(std::size_t i) const {
    if (i % 4096 == 0) progress_.check();
  }

  /// Axiom 1: a binary tree in preorder. The references of a node are those of its children.
  bool check_graph() {
    if (nodes_.empty()) return fail(0, "axiom 1", "there is no root");
    struct Open {
      std::size_t end, depth;  // of an unfinished subtree: its end, and the depth of its next node
    };
    std::vector<Open> open{{nodes_.size(), 0}};
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      check_cancelled(i);
      const Node& node = nodes_[i];
      while (!open.empty() && open.back().end == i) open.pop_back();
      if (open.empty()) return fail(i, "axiom 1", "it is the child of no node");
      auto& [end, depth] = open.back();
      if (depth > kMaxDepth)
        return fail(i, "the bound on depth",
                    "it is more than " + std::to_string(kMaxDepth) + " levels below the root; build a flatter tree");
      if (std::size_t(node.first_ref) + node.n_refs > refs_.size())
        return fail(i, "axiom 2", "its references reach past the end of the list");
      if (node.is_leaf()) {
        if (end != i + 1) return fail(i, "axiom 1", "a leaf, where an inner node is due");
        continue;
      }
      if (node.right <= i + 1 || node.right >= end)
        return fail(i, "axiom 1", "its right child " + std::to_string(node.right) + " is not in its own subtree");
      ++depth;
      open.push_back({node.right, depth});
      const Node &left = nodes_[i + 1], &right = nodes_[node.right];
      if (left.first_ref != node.first_ref || right.first_ref != left.first_ref + left.n_refs ||
          node.n_refs != left.n_refs + right.n_refs)
        return fail(i, "axiom 2", "its references are not those of its two children");
    }
    if (nodes_[0].first_ref != 0 || nodes_[0].n_refs != refs_.size())
      return fail(0, "axiom 3", "not all references are below the root");
    return true;
  }

  /// Axiom 2: boxes are finite and not empty, and each reference names a primitive and a piece of it.
  bool check_references() {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      check_cancelled(i);
      for (int k = 0; k < 3; ++k) {
        const float lo = nodes_[i].box.lo[k], hi = nodes_[i].box.hi[k];
        if (!(lo <= hi) || std::isinf(lo) || std::isinf(hi)) return fail(i, "axiom 2", "its box is not a box");
      }
    }
    for (std::size_t i = 0; i < refs_.size(); ++i) {
      check_cancelled(i);
      if (refs_[i].prim >= prims_.size())
        return fail(
            leaf_of(i), "axiom 2",
            "reference " + std::to_string(i) + " names none of the " + std::to_string(prims_.size()) + " primitives");
      if (!is_piece(refs_[i]))
        return fail(leaf_of(i), "axiom 2", "reference " + std::to_string(i) + " is not a piece of a primitive");
    }
    return true;
  }

  /// Whether a reference names a piece. Only curves have pieces, cut between s = 0 and 1; the last piece extends to ∞.
  static bool is_piece(const Reference& ref) {
    if (!Curves<P>) return ref.s0 == 0.0f && ref.s1 == kInfinity;
    return 0.0f <= ref.s0 && ref.s0 <= std::min(ref.s1, 1.0f) && (ref.s1 <= 1.0f || std::isinf(ref.s1));
  }

  /// Axiom 3: the root is (P, AABB(∪P)).
  bool check_root() {
    if (prims_.size() == 0) return refs_.empty() || fail(0, "axiom 3", "it lists references of no primitives");
    if (!(nodes_[0].box == bounds_of_all(prims_)))
      return fail(0, "axiom 3", "the root's box does not bound the primitives tightly");
    list_by_prim();
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim)
      if (refs_to(prim).empty()) return fail(0, "axiom 3", "primitive " + std::to_string(prim) + " is in no leaf");
    return true;
  }

  /// Axiom 4 and the KD axiom.
  bool check_boxes() {
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      check_cancelled(i);
      const Node& node = nodes_[i];
      if (node.is_leaf()) continue;
      const Box &left = nodes_[i + 1].box, &right = nodes_[node.right].box;
      if (!node.box.contains(left) || !node.box.contains(right))
        return fail(i, "axiom 4", "the boxes of its children do not lie in its own");
      if (rule_ == BoxRule::cut && !cut_in_two(node.box, left, right))
        return fail(i, "KD axiom", "the boxes of its children do not cut its own in two");
    }
    return true;
  }

  /// Whether the children's boxes are the two halves of a box.
  static bool cut_in_two(const Box& box, const Box& left, const Box& right) {
    int n_cut = 0;
    for (int k = 0; k < 3; ++k) {
      if (left.lo[k] != box.lo[k] || right.hi[k] != box.hi[k]) return false;
      if (left.hi[k] == box.hi[k] && right.lo[k] == box.lo[k]) continue;
      if (left.hi[k] != right.lo[k]) return false;
      ++n_cut;
    }
    return n_cut == 1;
  }

  /// Each hit is found at most once because the pieces of a primitive tile it, and at least once because each piece
  /// lies in its leaf's box. Queries count a primitive without pieces once, wherever they find it.
  bool check_pieces() {
    if constexpr (Curves<P>)
      return check_tiles() && check_leaves();
    else
      return check_coverage();
  }

  /// The pieces of each primitive tile it.
  bool check_tiles() {
    std::vector<std::uint32_t> pieces;
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim) {
      check_cancelled(prim);
      const std::span<const std::uint32_t> listed = refs_to(prim);
      pieces.assign(listed.begin(), listed.end());
      if (pieces.size() > 1)
        std::sort(pieces.begin(), pieces.end(), [this](std::uint32_t a, std::uint32_t b) {
          return refs_[a].s0 != refs_[b].s0 ? refs_[a].s0 < refs_[b].s0 : refs_[a].s1 < refs_[b].s1;
        });
      float reached = 0.0f;
      for (const std::uint32_t& piece : pieces) {
        const auto& [_, s0, s1] = refs_[piece];
        if (s0 != reached || std::isinf(s1) != (&piece == &pieces.back()))
          return fail(leaf_of(piece), "axiom 5", "the pieces of primitive " + std::to_string(prim) + " do not tile it");
        reached = s1;
      }
    }
    return true;
  }

  /// Each piece lies in its leaf's box, up to the slack.
  bool check_leaves() {
    const double slack = slack_of(nodes_[0].box);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      check_cancelled(i);
      if (!nodes_[i].is_leaf()) continue;
      const Box& box = nodes_[i].box;
      for (std::size_t k = nodes_[i].first_ref; k < std::size_t(nodes_[i].first_ref) + nodes_[i].n_refs; ++k) {
        prefetch_ahead(k);
        const auto& [prim, s0, s1] = refs_[k];
        Box ends = Box::empty();
        ends.grow(prims_.curve(prim).point(s0));
        ends.grow(prims_.curve(prim).point(std::min(s1, 1.0f)));
        for (int axis = 0; axis < 3; ++axis)
          if (ends.lo[axis] < box.lo[axis] - slack || ends.hi[axis] > box.hi[axis] + slack)
            return fail(i, "axiom 5", "a piece of primitive " + std::to_string(prim) + " is not in its leaf's box");
      }
    }
    return true;
  }

  /// The leaves that list a primitive cover it.
  bool check_coverage() {
    std::vector<std::uint32_t> leaf_of_ref(refs_.size());
    for (std::uint32_t i = 0; i < nodes_.size(); ++i)
      if (nodes_[i].is_leaf()) std::fill_n(leaf_of_ref.begin() + nodes_[i].first_ref, nodes_[i].n_refs, i);
    Coverage<P> covers(prims_, 2.0 * slack_of(nodes_[0].box));
    std::vector<Box> leaves;
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim) {
      check_cancelled(prim);
      leaves.clear();
      for (const std::uint32_t ref : refs_to(prim)) leaves.push_back(nodes_[leaf_of_ref[ref]].box);
      if (!covers(prim, leaves))
        return fail(leaf_of_ref[refs_to(prim).front()], "axiom 5",
                    "a part of primitive " + std::to_string(prim) + " is in none of the leaves that list it");
    }
    return true;
  }

  /// Prefetch the primitive of a later reference.
  void prefetch_ahead(std::size_t ref) const {
    constexpr std::size_t kPrefetchDistance = 16;  // references
    if (ref + kPrefetchDistance < refs_.size()) prefetch(prims_, refs_[ref + kPrefetchDistance].prim);
  }

  /// Sort the references by primitive (counting sort); those of one primitive stay in the order of the leaves.
  void list_by_prim() {
    ends_.assign(prims_.size() + 1, 0);
    for (const Reference& ref : refs_) ++ends_[ref.prim + 1];
    for (std::size_t prim = 0; prim < prims_.size(); ++prim) ends_[prim + 1] += ends_[prim];
    by_prim_.resize(refs_.size());
    for (std::size_t i = 0; i < refs_.size(); ++i) {
      check_cancelled(i);
      by_prim_[ends_[refs_[i].prim]++] = std::uint32_t(i);
    }
  }

  /// The references to a primitive, in the order of the leaves. Needs `list_by_prim`.
  std::span<const std::uint32_t> refs_to(std::uint32_t prim) const {
    const std::uint32_t begin = prim == 0 ? 0 : ends_[prim - 1];
    return std::span(by_prim_).subspan(begin, ends_[prim] - begin);
  }

  /// The leaf that lists a reference.
  std::size_t leaf_of(std::size_t ref) const {
    std::size_t i = 0;
    while (!nodes_[i].is_leaf()) i = ref < nodes_[nodes_[i].right].first_ref ? i + 1 : nodes_[i].right;
    return i;
  }

  const P& prims_;
  Nodes nodes_;
  References refs_;
  BoxRule rule_;
  const Progress& progress_;
  std::optional<Violation> found_;

 private:
  std::vector<std::uint32_t> by_prim_, ends_;  // references by primitive, and where those of each primitive end
};

/// The first violation that would make searches on this tree wrong, if there is one.
template <Primitives P>
std::optional<Violation> check_usable(const P& prims, std::span<const Node> nodes, std::span<const Reference> refs,
                                      BoxRule rule, const Progress& progress = {}) {
  return Usable<P>(prims, nodes, refs, rule, progress)();
}

}  // namespace fastlines
