// Chains of a hundred wide nodes, deeper than any builder makes them, over one segment, and rays along them.
#pragma once

#include <algorithm>
#include <vector>

#include "fastlines/layout/wide_bvh.hpp"
#include "fastlines/rays/ray_batch.hpp"

namespace fastlines::test {

inline constexpr int kDepth = 100, kRays = 300;
inline constexpr float kFrom = -2.0f, kScale = 4.0f / 255.0f;  // blocks reach from −2 to 2

inline WideNode node_of(int n_inner, int n_children, int first_inner) {
  WideNode node{};
  for (float& at : node.org) at = kFrom;
  node.scale = kScale;
  node.n_inner = std::uint8_t(n_inner);
  node.n_children = std::uint8_t(n_children);
  node.first_inner = std::uint32_t(first_inner);
  for (int k = 3; k < 6; ++k) std::fill_n(node.planes + k * kSimdWidth, n_children, std::uint8_t(255));
  return node;
}

/// Which of two children continues a chain at this depth.
using ChildOfDepth = int (*)(int depth);
inline int first_child(int) { return 0; }
inline int second_child(int) { return 1; }
inline int child_in_turn(int depth) { return depth % 2; }

/// A chain in which each node has two inner children, one of them empty. The deepest node has the leaf.
inline std::vector<WideNode> nodes_of(ChildOfDepth child) {
  std::vector<WideNode> nodes(2 * kDepth + 1, node_of(0, 0, 0));
  std::size_t at = 0;
  for (int depth = 0; depth < kDepth; ++depth) {
    const int first = 1 + 2 * depth;
    nodes[at] = node_of(2, 2, first);
    at = std::size_t(first + child(depth));
  }
  nodes[at] = node_of(0, 1, 0);
  return nodes;
}

/// A chain of nodes, the segment in its leaf, and rays.
struct Chain {
  Segment segment{{-1.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}};
  std::vector<WideNode> nodes;
  WideLeaf leaf{};
  std::vector<WideRef> refs;
  std::vector<Vec3> origins, directions;
  float radius = 0.01f, t_min = 0.0f, t_max = 100.0f;

  explicit Chain(ChildOfDepth child)
      : nodes(nodes_of(child)), refs(kSimdWidth, WideRef(Reference{0})), directions(kRays, Vec3{0.0f, 0.0f, 1.0f}) {
    for (float& from : leaf.org) from = kFrom;
    leaf.scale = kScale;
    leaf.inv_scale = 1.0f / kScale;
    leaf.n_refs = 1;
    std::fill(std::begin(leaf.ends), std::end(leaf.ends), std::uint8_t(128));
    for (int i = 0; i < kRays; ++i) origins.push_back({float(i % 7) * 1e-4f, hits(i) ? 0.0f : 0.5f, -5.0f});
  }

  /// Every third ray passes through all boxes but misses the segment.
  static bool hits(int ray) { return ray % 3 != 0; }

  WideBvhView<Segments> view() const {
    const Box box{{-2.0f, -2.0f, -2.0f}, {2.0f, 2.0f, 2.0f}};
    const Frame frame{.centre = {0.0f, 0.0f, 0.0f}, .scale = 1.0f, .overhang = 1e-5f};
    return {frame, box, 1.0f, nodes.data(), &leaf, refs.data(), &segment};
  }

  RayBatch rays() const { return {origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}}; }
};

}  // namespace fastlines::test
