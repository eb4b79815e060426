// The search of a KD tree by its planes (thesis §1.2.2, §1.3): an inner node is an axis and a plane, not two boxes.
//
// A ray carries the part [t_enter, t_leave] of itself that is in the node's box, grown by its radius. A plane divides
// that part: what comes before the plane ends where the ray leaves the plane moved on by the radius, and what lies
// beyond begins where the ray enters the plane moved back by the radius. So the parts of two children overlap, and
// each is what the test of the child's grown box gives.
//
// The thesis counts a hit only inside the leaf that found it. Here a hit counts wherever it is found: with a radius,
// the ray may be outside all leaves that list the segment. A visited set (a mailbox: Amanatides and Woo 1987) lets each
// segment be tested once a ray, so each hit counts once. A first hit ends the search of all that begins beyond it.
//
// Siblings stand side by side, the lower half first, so that a step down reads one cache line. Blocks of two lines hold
// a subtree: its nodes are added in the order of their surface area, which is the order of the chance of a visit.
#pragma once

#include <algorithm>
#include <bit>

#include "../threads/progress.hpp"
#include "search.hpp"
#include "visited_set.hpp"

namespace fastlines {

/// A node of a KD tree in eight bytes.
struct PlaneNode {
  static constexpr std::uint32_t kLeaf = 3, kShift = 2;

  std::uint32_t word = 0;      // of an inner node the bits of its plane, in the frame; of a leaf its first reference,
                               // or the primitive itself where it has one
  std::uint32_t link = kLeaf;  // the pair of its children, or how many references, above two bits: the axis, or kLeaf

  static PlaneNode inner(int axis, float plane, std::size_t pair) {
    return {std::bit_cast<std::uint32_t>(plane), std::uint32_t(pair) << kShift | std::uint32_t(axis)};
  }
  static PlaneNode leaf(const Node& leaf, std::span<const Reference> refs) {
    const std::uint32_t word = leaf.n_refs == 1 ? refs[leaf.first_ref].prim : leaf.first_ref;
    return {word, leaf.n_refs << kShift | kLeaf};
  }

  bool is_leaf() const { return (link & kLeaf) == kLeaf; }
  bool is_empty() const { return link == kLeaf; }
  int axis() const { return int(link & kLeaf); }
  float plane() const { return std::bit_cast<float>(word); }
  std::uint32_t lower_child() const { return link >> kShift << 1; }
  std::uint32_t n_refs() const { return link >> kShift; }
};
static_assert(sizeof(PlaneNode) == 8);

/// A KD tree as its planes, and the primitive of each reference.
struct PlaneTree {
  /// How many pairs of siblings a block of two cache lines holds.
  static constexpr std::size_t kBlockPairs = 8;
  static constexpr std::size_t kMaxCount = std::size_t(1) << (32 - PlaneNode::kShift);

  LargeVector<PlaneNode> nodes;  // the root is the first; the second is unused
  LargeVector<std::uint32_t> prims;
  std::uint32_t depth = 0;
};

/// The axis that the boxes of a node's two children are cut across.
inline int cut_axis(const Box& box, const Box& left, const Box& right) {
  int axis = 0;
  while (axis < 2 && left.hi[axis] == box.hi[axis] && right.lo[axis] == box.lo[axis]) ++axis;
  return axis;
}

/// Writes a KD tree, which `check_usable` accepts, as its planes.
class PlaneTreeWriter {
 public:
  PlaneTreeWriter(std::span<const Node> nodes, std::span<const Reference> refs)
      : nodes_(nodes), refs_(refs), frame_(frame_of(nodes[0].box)) {}

  PlaneTree operator()(Progress& progress) {
    if (refs_.size() >= PlaneTree::kMaxCount) refuse();
    PlaneTree to;
    to.nodes.reserve(nodes_.size() + nodes_.size() / 2);
    to.nodes.resize(2);
    to.prims.resize(refs_.size());
    std::ranges::transform(refs_, to.prims.begin(), &Reference::prim);
    std::vector<Open> waiting;  // the roots of later blocks
    add({0, 0, 0}, to, waiting);
    for (std::size_t n_blocks = 0; !waiting.empty(); ++n_blocks) {
      if (n_blocks % 1024 == 0) progress.check();
      open_.assign(1, waiting.back());
      waiting.pop_back();
      write_block(to);
      // The largest of those that found no room comes next.
      std::ranges::sort(open_, {}, [this](const Open& open) { return area(open); });
      waiting.insert(waiting.end(), open_.begin(), open_.end());
    }
    return to;
  }

 private:
  /// An inner node whose children are not written yet, and where it stands itself.
  struct Open {
    std::uint32_t node;
    std::size_t to;
    std::uint32_t depth;
  };

  [[noreturn]] static void refuse() {
    throw std::length_error(
        "a search by planes takes fewer than 2^30 references and pairs of nodes; use another kernel");
  }

  double area(const Open& open) const { return nodes_[open.node].box.area(); }

  /// Write the nodes below an open one, as many pairs as there is room for; those that find none stay open.
  void write_block(PlaneTree& to) {
    std::size_t next = to.nodes.size() == 2 ? 2 : round_up(to.nodes.size());
    const std::size_t end = round_up(next + 1);
    if (end > 2 * PlaneTree::kMaxCount) refuse();
    to.nodes.resize(end);
    for (; next < end && !open_.empty(); next += 2) {
      const auto largest = std::ranges::max_element(open_, {}, [this](const Open& open) { return area(open); });
      const Open parent = *largest;
      open_.erase(largest);
      const std::uint32_t left = parent.node + 1, right = nodes_[parent.node].right;
      const int axis = cut_axis(nodes_[parent.node].box, nodes_[left].box, nodes_[right].box);
      const float plane = Slabs::in_frame(frame_, axis, nodes_[left].box.hi[axis]);
      to.nodes[parent.to] = PlaneNode::inner(axis, plane, next / 2);
      add({left, next, parent.depth + 1}, to, open_);
      add({right, next + 1, parent.depth + 1}, to, open_);
    }
    to.nodes.resize(next);
  }

  /// Write a leaf, or add an inner node to those that are open.
  void add(const Open& node, PlaneTree& to, std::vector<Open>& open) const {
    to.depth = std::max(to.depth, node.depth);
    if (nodes_[node.node].is_leaf())
      to.nodes[node.to] = PlaneNode::leaf(nodes_[node.node], refs_);
    else
      open.push_back(node);
  }

  static std::size_t round_up(std::size_t n_nodes) {
    constexpr std::size_t block = 2 * PlaneTree::kBlockPairs;
    return (n_nodes + block - 1) / block * block;
  }

  std::span<const Node> nodes_;
  std::span<const Reference> refs_;
  Frame frame_;
  std::vector<Open> open_;  // in the block that is being written
};

/// Depth first, the nearer child first; a part of the ray that begins beyond the sink's limit is left out.
struct PlaneSearch {
  struct Scratch {
    struct Entry {
      std::uint32_t node;
      float t_enter, t_leave;
    };
    std::vector<Entry> stack;
    VisitedSet visited;
  };

  std::span<const PlaneNode> nodes;
  std::span<const std::uint32_t> prims;
  std::uint32_t depth;
  std::span<const Segment> segments;
  Box box;  // of the root
  Frame frame;

  template <class Sink>
  void operator()(const Ray& ray, Sink& sink, Scratch& scratch) const {
    using Entry = typename Scratch::Entry;
    const Slabs slabs(ray, frame);
    // Each level leaves at most one node for later.
    if (scratch.stack.size() <= depth) scratch.stack.resize(depth + 1);
    scratch.visited.clear();
    const auto [root_enter, root_leave] = slabs.clip(box, sink.limit);
    Entry *const bottom = scratch.stack.data(), *top = bottom;
    *top++ = {0, root_enter, root_leave};
    while (top != bottom) {
      auto [index, t_enter, t_leave] = *--top;
      t_leave = std::min(t_leave, sink.limit);
      if (!(t_enter <= t_leave)) continue;

      // Go down to a leaf, leaving the farther children for later. Which child comes next can not be foreseen, so
      // nothing branches.
      PlaneNode node = nodes[index];
      while (!node.is_leaf()) {
        const int axis = node.axis();
        const std::uint32_t i_near = node.lower_child() + slabs.is_backwards(axis), i_far = i_near ^ 1;
        const PlaneNode near = nodes[i_near], far = nodes[i_far];
        const float end_near = slabs.leave_before(axis, node.plane());
        const float begin_far = std::max(t_enter, slabs.enter_beyond(axis, node.plane()));
        const bool in_far = begin_far <= t_leave;
        const bool to_near = bool(int(end_near >= t_enter) & ~(int(in_far) & int(near.is_empty())));
        __builtin_prefetch(other_line(near));
        fetch(far);
        *top = {i_far, begin_far, t_leave};
        top += to_near & in_far & !far.is_empty();
        node.word = to_near ? near.word : far.word;
        node.link = to_near ? near.link : far.link;
        t_leave = to_near ? std::min(t_leave, end_near) : t_leave;
        t_enter = to_near ? t_enter : begin_far;
      }

      // Test what the leaf lists and no other has.
      const std::span<const std::uint32_t> below =
          node.n_refs() == 1 ? std::span(&node.word, 1) : prims.subspan(node.word, node.n_refs());
      if (below.size() > 1)
        for (const std::uint32_t prim : below) __builtin_prefetch(&segments[prim]);
      scratch.visited.reserve(below.size());
      for (const std::uint32_t prim : below) {
        if (!scratch.visited.insert(prim)) continue;
        test_segment(ray, segments[prim], frame, Reference{prim}, sink);
        if (sink.done()) return;
      }
    }
  }

 private:
  /// The line that shares a block with the one that the children of the node are in.
  const void* other_line(const PlaneNode& node) const {
    constexpr std::uint32_t kLine = PlaneTree::kBlockPairs;
    return &nodes.data()[node.lower_child() ^ kLine];
  }

  /// Ask for what a visit of the node reads first: the pair of its children, or its one segment.
  [[gnu::always_inline]] void fetch(const PlaneNode& node) const {
    const void* const segment = &segments.data()[node.n_refs() == 1 ? node.word : 0];
    const void* const pair = &nodes.data()[node.lower_child()];
    __builtin_prefetch(node.is_leaf() ? segment : pair);
  }
};

}  // namespace fastlines
