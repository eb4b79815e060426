// Encodes boxes and pieces into the blocks of a wide BVH: the last step of a collapse, and the only step after segments
// have moved.
//
// The topology is given. The encoder writes the pieces of each leaf, computes boxes from the last node to the first,
// and writes the planes of each node. The arithmetic is float32: relative to the origin of a block, its error is 1e-4
// quanta. Both kinds of blocks have a slack that covers it: 0.02 quanta around boxes, and 0.89 quanta around the
// axes in a leaf.
#pragma once

#include <cstring>
#include <memory>
#include <span>

#include "../parallel/parallel_for.hpp"
#include "../references/piece_endpoints.hpp"
#include "leaf_bytes.hpp"
#include "wide_bvh.hpp"

namespace fastlines {

/// Encodes the nodes and leaves of a wide BVH.
template <RayPrimitive P>
class BlockEncoder {
 public:
  /// `to_nodes` and `to_leaves` may be the input blocks themselves. `piece_boxes` are those of all references; pieces
  /// of axes need none.
  BlockEncoder(const Frame& frame, std::span<const WideNode> nodes, std::span<const WideLeaf> leaves,
               std::span<const WideRef> refs, const P& prims, WideNode* to_nodes, WideLeaf* to_leaves,
               std::span<const Box> piece_boxes = {})
      : centre_{frame.centre[0], frame.centre[1], frame.centre[2], 0.0f},
        scale_(broadcast_x4(frame.scale)),
        nodes_(nodes),
        leaves_(leaves),
        refs_(refs),
        prims_(prims),
        to_nodes_(to_nodes),
        to_leaves_(to_leaves),
        piece_boxes_(piece_boxes),
        node_boxes_(std::make_unique_for_overwrite<BoxX4[]>(nodes.size())),
        leaf_boxes_(std::make_unique_for_overwrite<BoxX4[]>(leaves.size())) {}

  /// Encode all blocks. Returns the mean extent of the leaves, in the frame.
  float operator()(unsigned n_threads, Progress& progress, Stage stage = {}) {
    const double half = 0.5 * (stage.from + stage.to);
    for_each_block(leaves_.size(), n_threads, progress, {stage.from, half}, [&](std::size_t i) { encode_leaf(i); });
    // Compute boxes from the bottom up: children have larger indices.
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      const WideNode& node = nodes_[i];
      BoxX4 box = BoxX4::empty();
      for (int child = 0; child < node.n_children; ++child) box.grow(box_of(node, child));
      node_boxes_[i] = box;
    }
    for_each_block(nodes_.size(), n_threads, progress, {half, stage.to}, [&](std::size_t i) { encode_node(i); });
    double extents = 0.0;
    for (std::size_t i = 0; i < leaves_.size(); ++i) extents += 255.0 * to_leaves_[i].scale;
    return float(extents / double(leaves_.size()));
  }

 private:
  /// How many references ahead primitives are prefetched.
  static constexpr std::size_t kPrefetchDistance = 16;

  /// Call encode(i) for all i < n, in parallel.
  template <class Encode>
  static void for_each_block(std::size_t n, unsigned n_threads, Progress& progress, Stage stage, Encode&& encode) {
    constexpr std::size_t chunk_size = 1024;  // blocks
    parallel_for_chunks(
        n, chunk_size, n_threads, progress, [] { return 0; },
        [&](int, std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) encode(i);
        },
        stage);
  }

  /// The box of a child, in the frame.
  const BoxX4& box_of(const WideNode& node, int child) const {
    return child < node.n_inner ? node_boxes_[node.first_inner + std::size_t(child)]
                                : leaf_boxes_[node.first_leaf + std::size_t(child - node.n_inner)];
  }

  using Bytes16 = std::uint8_t __attribute__((vector_size(16)));

  /// The longest side, but at least a millionth of the frame, so that a scale is never zero.
  static float longest_of(const BoxX4& box) {
    const FloatX4 sides = box.hi - box.lo;
    return std::max(std::max(sides[0], sides[1]), std::max(sides[2], 0x1p-20f));
  }

  void encode_leaf(std::size_t index) const {
    if constexpr (AxisPrimitive<P>) {
      encode_axes(index);
      return;
    }
    if constexpr (MixedPrimitive<P>) {
      const WideLeaf& leaf = leaves_[index];
      const auto has_axis = [this](const WideRef& ref) { return P::has_axis(prims_.item(ref.prim)); };
      if (std::ranges::all_of(refs_.subspan(leaf.first_ref, leaf.n_refs), has_axis)) {
        encode_axes(index);
        leaf_boxes_[index] = hull_of_pieces(index);
        return;
      }
    }
    if constexpr (!AxisPrimitive<P>) encode_boxes(index);
  }

  /// The box of a reference, in the frame.
  BoxX4 piece_box(std::size_t ref) const {
    const auto [lo, hi] = piece_boxes_[ref];
    return {(FloatX4{lo[0], lo[1], lo[2], 0.0f} - centre_) * scale_,
            (FloatX4{hi[0], hi[1], hi[2], 0.0f} - centre_) * scale_};
  }

  BoxX4 hull_of_pieces(std::size_t index) const {
    BoxX4 box = BoxX4::empty();
    for (std::uint32_t i = 0; i < leaves_[index].n_refs; ++i) box.grow(piece_box(leaves_[index].first_ref + i));
    return box;
  }

  /// Encode the boxes of the pieces.
  void encode_boxes(std::size_t index) const {
    const std::uint32_t first_ref = leaves_[index].first_ref;
    const std::uint16_t n_refs = leaves_[index].n_refs;
    WideLeaf& leaf = to_leaves_[index];
    leaf_boxes_[index] = hull_of_pieces(index);
    leaf.first_ref = first_ref;
    leaf.n_refs = n_refs;
    leaf.shape = LeafShape::boxes;
    leaf.radius = 0.0f;
    encode_planes(
        leaf_boxes_[index], n_refs, [&](int i) { return piece_box(first_ref + std::uint32_t(i)); }, leaf, leaf.ends);
    leaf.inv_scale = 1.0f / leaf.scale;
  }

  /// Encode the axes of the pieces.
  void encode_axes(std::size_t index) const {
    const std::uint32_t first_ref = leaves_[index].first_ref, n_refs = leaves_[index].n_refs;
    const WideRef* const refs = refs_.data() + first_ref;
    const std::size_t last = refs_.size() - first_ref - 1;
    PieceEndpoints ends[kSimdWidth];
    BoxX4 box = BoxX4::empty(), grown = BoxX4::empty();  // of the axes, and of the axes grown by their radii
    float radius = 0.0f;
    for (std::uint32_t i = 0; i < n_refs; ++i) {
      __builtin_prefetch(prims_.items() + refs[std::min(i + kPrefetchDistance, last)].prim);
      const PieceEndpoints at = endpoints_of(P::axis(prims_.item(refs[i].prim)), refs[i]);
      ends[i] = {(at.a - centre_) * scale_, (at.c - centre_) * scale_};
      const BoxX4 piece = fastlines::box_of(ends[i]);
      box.grow(piece);
      if constexpr (kHasRadius<P>) {
        const float prim_radius = P::radius(prims_.item(refs[i].prim)) * scale_[0];
        grown.grow({piece.lo - broadcast_x4(prim_radius), piece.hi + broadcast_x4(prim_radius)});
        radius = std::max(radius, prim_radius);
      }
    }
    leaf_boxes_[index] = kHasRadius<P> ? grown : box;

    // Choose the grid: its origin is the low corner, the longest side takes 255 quanta.
    const FloatX4 org = n_refs ? box.lo : FloatX4{};
    for (std::uint32_t i = n_refs; i < kSimdWidth; ++i) ends[i] = {org, org};
    WideLeaf& leaf = to_leaves_[index];
    std::memcpy(leaf.org, &org, sizeof leaf.org);
    leaf.scale = longest_of(box) * float((1 + 1e-6) / 255);
    leaf.inv_scale = 1.0f / leaf.scale;
    leaf.first_ref = first_ref;
    leaf.n_refs = std::uint16_t(n_refs);
    leaf.shape = LeafShape::axes;
    leaf.radius = radius * leaf.inv_scale;
    const FloatX4 inv_scale = broadcast_x4(leaf.inv_scale);
    // Round ends to the nearest byte: add a half, because the conversion truncates.
    const auto nearest = [&](const FloatX4& x) { return (x - org) * inv_scale + broadcast_x4(0.5f); };
    for (int i = 0; i < kSimdWidth; i += 4) {
      FloatX4 a[4], c[4];
      for (int j = 0; j < 4; ++j) {
        a[j] = nearest(ends[i + j].a);
        c[j] = nearest(ends[i + j].c);
      }
      put_ends(bytes_of(a), bytes_of(c), leaf.ends, i);
    }
  }

  void encode_node(std::size_t index) const {
    const WideNode& from = nodes_[index];
    WideNode& node = to_nodes_[index];
    node.first_inner = from.first_inner;
    node.first_leaf = from.first_leaf;
    node.n_inner = from.n_inner;
    node.n_children = from.n_children;
    std::memset(node.unused, 0, sizeof node.unused);
    encode_planes(node_boxes_[index], node.n_children, [&](int i) { return box_of(node, i); }, node, node.planes);
  }

  /// Write n boxes into the planes of a block, and its grid. `all` bounds them.
  template <class BoxOf, class Block>
  [[gnu::always_inline]] static void encode_planes(const BoxX4& all, int n, const BoxOf& box_of, Block& block,
                                                   std::uint8_t* planes) {
    const float longest = longest_of(all);
    // Empty boxes, and lanes without a box, become a point.
    const FloatX4 point = all.is_empty() ? FloatX4{} : all.lo;
    BoxX4 boxes[kSimdWidth];
    for (int i = 0; i < kSimdWidth; ++i) {
      boxes[i] = i < n ? box_of(i) : BoxX4::empty();
      if (boxes[i].is_empty()) boxes[i] = {point, point};
    }
    const FloatX4 org = point - broadcast_x4(2e-4f * longest);
    std::memcpy(block.org, &org, sizeof block.org);
    block.scale = longest * float(1.0004 / 254);
    const FloatX4 inv_scale = broadcast_x4(1.0f / block.scale);
    // Round outwards, by 0.02 quanta at least. Rounding q ≤ 254 adds errors of 6e-5 quanta in all, and rounding
    // org + q·scale, as the test of a node computes it, half as much.
    const auto below = [&](const FloatX4& x) { return max((x - org) * inv_scale - broadcast_x4(0.02f), FloatX4{}); };
    const auto above = [&](const FloatX4& x) {
      const FloatX4 y = (x - org) * inv_scale + broadcast_x4(0.02f);
      const FloatX4 whole = __builtin_convertvector(__builtin_convertvector(y, IntX4), FloatX4);
      return min(whole < y ? whole + broadcast_x4(1.0f) : whole, broadcast_x4(255.0f));
    };
    auto* const rows = reinterpret_cast<std::uint8_t (*)[kSimdWidth]>(planes);
    for (int i = 0; i < kSimdWidth; i += 4) {
      FloatX4 low[4], high[4];
      for (int j = 0; j < 4; ++j) {
        low[j] = below(boxes[i + j].lo);
        high[j] = above(boxes[i + j].hi);
      }
      put_bytes(low, rows, i);
      put_bytes(high, rows + 3, i);
    }
    // Invert the boxes of lanes without a box, so that no ray enters them.
    for (int i = n; i < kSimdWidth; ++i)
      for (int k = 0; k < 3; ++k) {
        planes[k * kSimdWidth + i] = 255;
        planes[(k + 3) * kSimdWidth + i] = 0;
      }
  }

  /// Bytes of four points in quanta: x of all four, then y, then z.
  [[gnu::always_inline]] static Bytes16 bytes_of(const FloatX4 (&points)[4]) {
    IntX4 words{};
    for (int j = 0; j < 4; ++j) words |= __builtin_convertvector(points[j], IntX4) << (8 * j);
    return Bytes16(words);
  }

  /// Write four points, in quanta, to the rows of x, y and z.
  [[gnu::always_inline]] static void put_bytes(const FloatX4 (&points)[4], std::uint8_t (*rows)[kSimdWidth],
                                               int first) {
    const Bytes16 bytes = bytes_of(points);
    for (int k = 0; k < 3; ++k) std::memcpy(rows[k] + first, reinterpret_cast<const char*>(&bytes) + 4 * k, 4);
  }

  /// Write the ends of four pieces in the order of `end_byte`.
  [[gnu::always_inline]] static void put_ends(const Bytes16& a, const Bytes16& c, std::uint8_t* ends, int first) {
    const auto put = [&](const Bytes16& pairs, int at) { std::memcpy(ends + at, &pairs, 8); };
    const auto in_pairs = [](const Bytes16& x) {
      return __builtin_shufflevector(x, x, 0, 4, 1, 5, 2, 6, 3, 7, 0, 4, 1, 5, 2, 6, 3, 7);
    };
    put(in_pairs(a), end_byte(0, 0, first));
    put(in_pairs(c), end_byte(1, 0, first));
    put(__builtin_shufflevector(a, c, 8, 24, 9, 25, 10, 26, 11, 27, 8, 24, 9, 25, 10, 26, 11, 27),
        end_byte(0, 2, first));
  }

  FloatX4 centre_, scale_;
  std::span<const WideNode> nodes_;
  std::span<const WideLeaf> leaves_;
  std::span<const WideRef> refs_;
  P prims_;
  WideNode* to_nodes_;
  WideLeaf* to_leaves_;
  std::span<const Box> piece_boxes_;
  std::unique_ptr<BoxX4[]> node_boxes_, leaf_boxes_;
};

}  // namespace fastlines
