// Checks all that searches of a wide BVH rely on, so that a layout from a file cannot crash them. The time is linear in
// its size: some milliseconds a million references.
//
//   - Children lie behind their parents, every block but the root has one parent, and no node is deeper than kMaxDepth.
//   - Leaves list each reference once, in their order, and hold axes or boxes as their primitives require.
//   - References name primitives, and the pieces of each primitive have its length together.
//   - Grids are finite and have a size.
//
// Whether boxes bound what lies below them is not checked: that takes as long as encoding them.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "../parallel/progress.hpp"
#include "wide_bvh.hpp"

namespace fastlines {

/// Checks one layout; the references to its data must stay valid.
template <RayPrimitive P>
class LayoutCheck {
 public:
  LayoutCheck(std::span<const WideNode> nodes, std::span<const WideLeaf> leaves, std::span<const WideRef> refs,
              const P& prims, const Progress& progress)
      : nodes_(nodes), leaves_(leaves), refs_(refs), prims_(prims), progress_(progress) {}

  /// What is wrong, or nothing.
  std::optional<std::string> operator()() {
    check_nodes() && check_leaves() && check_refs();
    return found_;
  }

 private:
  bool fail(const char* kind, std::size_t index, const std::string& detail) {
    found_ = std::string(kind) + " " + std::to_string(index) + " of the layout " + detail;
    return false;
  }

  void check_cancelled(std::size_t i) const {
    if (i % 4096 == 0) progress_.check();
  }

  /// Whether a grid is finite and has a size.
  template <class Block>
  static bool has_grid(const Block& block) {
    bool is_grid = block.scale > 0.0f && std::isfinite(block.scale);
    for (const float at : block.org) is_grid &= std::isfinite(at);
    return is_grid;
  }

  bool check_nodes() {
    if (nodes_.empty()) return fail("node", 0, "is missing");
    if (nodes_.size() > kNoBlock || leaves_.size() > kNoBlock || refs_.size() > kNoBlock)
      return fail("node", 0, "has more blocks below it than 32 bits can number");
    std::vector<std::uint16_t> depth(nodes_.size());  // plus 1; 0 of nodes that no parent has named
    std::vector<bool> has_parent(leaves_.size());
    depth[0] = 1;
    std::size_t n_leaves = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      check_cancelled(i);
      const WideNode& node = nodes_[i];
      const std::size_t first_inner = node.first_inner, first_leaf = node.first_leaf, n_inner = node.n_inner;
      if (depth[i] == 0) return fail("node", i, "is no child of a node before it");
      if (depth[i] > kMaxDepth) return fail("node", i, "is too deep");
      if (!has_grid(node)) return fail("node", i, "has no finite grid");
      if (node.n_children == 0 || node.n_children > kSimdWidth || n_inner > node.n_children)
        return fail("node", i, "has a wrong number of children");
      const std::size_t n_below = node.n_children - n_inner;
      if (n_inner > 0 && (first_inner <= i || first_inner + n_inner > nodes_.size()))
        return fail("node", i, "has children that are not nodes behind it");
      if (n_below > 0 && first_leaf + n_below > leaves_.size())
        return fail("node", i, "has children beyond the leaves");
      for (std::size_t child = 0; child < n_inner; ++child) {
        if (depth[first_inner + child] != 0) return fail("node", first_inner + child, "has two parents");
        depth[first_inner + child] = std::uint16_t(depth[i] + 1);
      }
      for (std::size_t child = 0; child < n_below; ++child) {
        if (has_parent[first_leaf + child]) return fail("leaf", first_leaf + child, "has two parents");
        has_parent[first_leaf + child] = true;
      }
      n_leaves += n_below;
    }
    return n_leaves == leaves_.size() || fail("node", 0, "does not have all leaves below it");
  }

  bool check_leaves() {
    std::size_t end = 0;  // of the references of the leaves before
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      check_cancelled(i);
      const WideLeaf& leaf = leaves_[i];
      if (leaf.first_ref != end || leaf.n_refs > kSimdWidth || leaf.n_refs > refs_.size() - end)
        return fail("leaf", i, "does not list the references that follow those of the leaf before it");
      end += leaf.n_refs;
      if (leaf.shape != LeafShape::axes && leaf.shape != LeafShape::boxes) return fail("leaf", i, "has no known shape");
      if constexpr (!MixedPrimitive<P>)
        if ((leaf.shape == LeafShape::axes) != AxisPrimitive<P>) return fail("leaf", i, "has another shape");
      if (!has_grid(leaf) || !(leaf.inv_scale > 0.0f && std::isfinite(leaf.inv_scale)) ||
          !(leaf.radius >= 0.0f && std::isfinite(leaf.radius)))
        return fail("leaf", i, "has no finite grid");
    }
    return end == refs_.size() || fail("leaf", leaves_.size(), "is missing: there are more references");
  }

  bool check_refs() {
    std::vector<std::uint32_t> covered(prims_.size());  // the lengths of the pieces together, in 65536ths
    for (std::size_t i = 0; i < refs_.size(); ++i) {
      check_cancelled(i);
      const WideRef& ref = refs_[i];
      if (ref.prim >= covered.size()) return fail("reference", i, "names a primitive that is not there");
      const std::uint32_t end = ref.s1 == 0xffff ? kWhole : ref.s1;
      if (ref.s0 > end || (!AxisPrimitive<P> && end - ref.s0 != kWhole))
        return fail("reference", i, "is not a piece of its primitive");
      covered[ref.prim] += AxisPrimitive<P> || covered[ref.prim] == 0 ? end - ref.s0 : 0;
    }
    const auto gap = std::ranges::find_if(covered, [](std::uint32_t length) { return length != kWhole; });
    return gap == covered.end() ||
           fail("reference", std::size_t(gap - covered.begin()), "is not a piece of its primitive");
  }

  static constexpr std::size_t kNoBlock = 0xffff'ffff;
  static constexpr std::uint32_t kWhole = 0x10000;

  std::span<const WideNode> nodes_;
  std::span<const WideLeaf> leaves_;
  std::span<const WideRef> refs_;
  P prims_;
  const Progress& progress_;
  std::optional<std::string> found_;
};

/// What is wrong with a layout that is over these primitives, or nothing.
template <RayPrimitive P>
std::optional<std::string> check_layout(std::span<const WideNode> nodes, std::span<const WideLeaf> leaves,
                                        std::span<const WideRef> refs, const P& prims, const Progress& progress) {
  return LayoutCheck(nodes, leaves, refs, prims, progress)();
}

}  // namespace fastlines
