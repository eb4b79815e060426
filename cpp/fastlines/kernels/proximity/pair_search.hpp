// Finds all pairs of primitives of two wide BVHs, or of one, whose distance is at most a radius.
//
// Each block of up to 16 pieces of the first set searches the tree of the second one, as a box grown by the radius. In
// each leaf that it reaches, it culls 16 pieces at a time (piece_block.hpp). Pairs that survive wait until there are 16
// of them for the exact test, which reads the primitives themselves. A pair is reported by the pieces that own its
// places, so once. In a self-join, each pair of leaves is visited once.
//
// Leaves of shapes list whole ones, and several leaves may list the same. Of those that come near the second tree, a
// shape searches from the first one, and notes which others it has met.
//
// The search computes in the frame of the query. Boxes grow by the rounding of the exact test, by the overhang of both
// trees, and by a fraction of the radii.
#pragma once

#include <bit>
#include <numeric>
#include <vector>

#include "../../primitives/pair_test.hpp"
#include "../../query/proximity/pair_list.hpp"
#include "../../query/visited_set.hpp"
#include "../../rays/hit_order.hpp"
#include "piece_block.hpp"

namespace fastlines {

/// The blocks of a wide BVH. Without leaves, all primitives are whole, in blocks of 16 consecutive ones.
struct PairTree {
  Frame frame;
  std::span<const WideNode> nodes;
  std::span<const WideLeaf> leaves;
  std::span<const WideRef> refs;
};

template <bool surface>
class PairSearch {
 public:
  PairSearch(const PairQuery& query, const PairTree& first, const PairTree& second)
      : query_(query),
        first_(first),
        second_(second),
        change_(first.frame, query.frame),
        second_change_(second.frame, query.frame),
        radius_(query.frame_radius()),
        radius2_(radius_ * radius_),
        to_scene_(1.0f / query.frame.scale) {
    second_repeats_ = repeats(query.second, second);
    constexpr float most = 1e15f;  // what is farther apart passes anyway
    reach_ = std::min(radius_, most) * kGrow + kRounding + first.frame.overhang * change_.scale +
             second.frame.overhang * second_change_.scale;
    blocks_ = near_blocks();
    if (repeats(query.first, first)) {
      first_leaf_.assign(query.first.n_rows, kNoLeaf);
      for (auto leaf = blocks_.rbegin(); leaf != blocks_.rend(); ++leaf)
        for (std::uint32_t i = 0; i < first.leaves[*leaf].n_refs; ++i)
          first_leaf_[first.refs[first.leaves[*leaf].first_ref + i].prim] = *leaf;
    }
  }

  void find(PairList& list, unsigned n_threads, Progress& progress, Stage stage) const {
    constexpr std::size_t chunk_size = 8;  // blocks
    parallel_for_chunks(
        blocks_.size(), chunk_size, n_threads, progress, [&] { return Worker(*this, *list.part(), progress); },
        [&](Worker& worker, std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) worker.search(blocks_[i]);
          worker.finish();
        },
        stage);
  }

 private:
  /// The rounding of the exact test; and a factor that covers that of radii.
  static constexpr float kRounding = 4 * 0x1p-20f, kGrow = 1.0f + 0x1p-18f;
  static constexpr std::uint32_t kNoRef = ~0u, kNoLeaf = ~0u;

  /// Whether several leaves list the same whole primitives.
  static bool repeats(const AxisSet& set, const PairTree& tree) {
    return set.lists_whole && tree.refs.size() > set.n_rows;
  }

  /// Whether a search from each of two primitives meets the other one. In a self-join, that of the first one counts.
  bool meets_twice() const { return query_.has_range() || !first_leaf_.empty(); }

  std::size_t n_blocks() const {
    if (!first_.leaves.empty()) return first_.leaves.size();
    return (query_.first.n_rows + kSimdWidth - 1) / kSimdWidth;
  }

  /// The blocks of the first set that come near the root of the second tree: few where two sets hardly touch.
  std::vector<std::uint32_t> near_blocks() const {
    std::vector<std::uint32_t> blocks(n_blocks());
    std::iota(blocks.begin(), blocks.end(), 0u);
    if (query_.is_self || first_.leaves.empty()) return blocks;
    blocks.clear();
    const SearchBox root = box_of(second_.nodes[0], second_change_);
    for (std::vector<std::uint32_t> stack{0}; !stack.empty();) {
      const WideNode& node = first_.nodes[stack.back()];
      stack.pop_back();
      for (std::uint32_t near = near_children(node, change_, root, reach_ * kGrow); near; near &= near - 1) {
        const int child = std::countr_zero(near);
        if (child < node.n_inner)
          stack.push_back(node.first_inner + std::uint32_t(child));
        else
          blocks.push_back(node.first_leaf + std::uint32_t(child - node.n_inner));
      }
    }
    std::sort(blocks.begin(), blocks.end());
    return blocks;
  }

  /// The box of a node in the frame of the query.
  static SearchBox box_of(const WideNode& node, const FrameChange& change) {
    SearchBox box;
    const float quantum = change.quantum(node.scale);
    for (int k = 0; k < 3; ++k) {
      const std::uint8_t *const low = node.planes + k * kSimdWidth, *const high = node.planes + (3 + k) * kSimdWidth;
      const float org = change.coordinate(node.org[k], k);
      box.low[k] = org + float(*std::min_element(low, low + node.n_children)) * quantum;
      box.high[k] = org + float(*std::max_element(high, high + node.n_children)) * quantum;
    }
    return box;
  }

  /// The children whose boxes come within reach of a box. They include radii.
  static std::uint32_t near_children(const WideNode& node, const FrameChange& change, const SearchBox& box,
                                     float reach) {
    const float inverse = 1.0f / change.quantum(node.scale);
    MaskX16 near = FloatX16(0.0f) <= FloatX16(0.0f);
    for (int k = 0; k < 3; ++k) {
      const float org = change.coordinate(node.org[k], k);
      const float low = (box.low[k] - reach - org) * inverse, high = (box.high[k] + reach - org) * inverse;
      near = near & (FloatX16::bytes(node.planes + k * kSimdWidth) <= FloatX16(high));
      near = near & (FloatX16(low) <= FloatX16::bytes(node.planes + (3 + k) * kSimdWidth));
    }
    return near.bits() & ((1u << node.n_children) - 1);
  }

  /// A pair of rows to be tested, and the references that led to it.
  struct Candidate {
    std::uint32_t i, j, ref_i, ref_j;
  };

  /// The search of one thread.
  class Worker {
   public:
    Worker(const PairSearch& search, PairList::Part& to, Progress& progress)
        : search_(search), query_(search.query_), to_(to), progress_(progress), checkpoint_(progress) {}

    /// Find the pairs of a block of the first set.
    void search(std::size_t index) {
      block_ = std::uint32_t(index);
      const PairTree& tree = search_.first_;
      if (tree.leaves.empty()) {
        const auto first = std::uint32_t(index * kSimdWidth);
        const std::uint32_t n = std::min(std::uint32_t(query_.first.n_rows) - first, std::uint32_t(kSimdWidth));
        for (std::uint32_t piece = 0; piece < n; ++piece) pieces_[piece] = {first + piece, kNoRef};
        PieceBlock block(query_.first, first, n, query_.frame);
        search(block, n);
      } else {
        const WideLeaf& leaf = tree.leaves[index];
        for (std::uint32_t piece = 0; piece < leaf.n_refs; ++piece) {
          const std::uint32_t ref = leaf.first_ref + piece;
          pieces_[piece] = {tree.refs[ref].prim, ref};
        }
        PieceBlock block(leaf, search_.change_);
        block.radius = leaf.radius * search_.change_.quantum(leaf.scale);
        search(block, leaf.n_refs);
      }
    }

    /// Test all candidates that are left.
    void finish() { test_candidates(0); }

   private:
    struct Piece {
      std::uint32_t prim, ref;
    };

    void search(PieceBlock& block, std::uint32_t n) {
      if (search_.meets_twice()) keep_first(block, n);
      if (block.lanes == 0) return;
      if (!surface) block.radius = 0.0f;
      slack_ = block.slack;
      const float reach = search_.reach_ + block.slack + block.radius * kGrow;
      for (int k = 0; k < 3; ++k) {
        box_.low[k] = reduce_min(block.low[k]);
        box_.high[k] = reduce_max(block.high[k]);
      }
      const PieceArrays arrays(block);
      const PieceSlabs slabs(block);
      stack_.assign(1, 0);
      if (search_.second_repeats_) met_.clear();
      while (!stack_.empty()) {
        const WideNode& node = search_.second_.nodes[stack_.back()];
        stack_.pop_back();
        checkpoint_.pass();
        for (std::uint32_t near = near_children(node, search_.second_change_, box_, reach); near; near &= near - 1) {
          const int child = std::countr_zero(near);
          if (child < node.n_inner)
            stack_.push_back(node.first_inner + std::uint32_t(child));
          else
            visit(slabs, arrays, node, child, reach);
        }
      }
    }

    /// Keep the pieces that can be the first of a pair, and that no leaf before has listed as a whole.
    void keep_first(PieceBlock& block, std::uint32_t n) const {
      for (int lane = 0; lane < kSimdWidth; ++lane) {
        const auto piece = std::uint32_t(piece_of_lane(lane));
        if (piece >= n) continue;
        const std::uint32_t row = pieces_[piece].prim;
        const bool is_first = search_.first_leaf_.empty() || search_.first_leaf_[row] == block_;
        if (!is_first || !query_.is_first(row)) block.lanes &= ~(1u << lane);
      }
    }

    /// Cull the pairs of a block and a leaf of the second tree.
    void visit(const PieceSlabs& slabs, const PieceArrays& arrays, const WideNode& node, int child, float reach) {
      const std::uint32_t index = node.first_leaf + std::uint32_t(child - node.n_inner);
      const bool once = query_.is_self && !search_.meets_twice();
      if (once && index < block_) return;
      const WideLeaf& leaf = search_.second_.leaves[index];
      const FrameChange& change = search_.second_change_;
      const float quantum = change.quantum(node.scale);
      SearchBox box;
      for (int k = 0; k < 3; ++k) {
        const float org = change.coordinate(node.org[k], k);
        box.low[k] = org + float(node.planes[k * kSimdWidth + child]) * quantum;
        box.high[k] = org + float(node.planes[(3 + k) * kSimdWidth + child]) * quantum;
      }
      std::uint32_t near = slabs.near(box, reach);
      if (near == 0) return;
      checkpoint_.pass();
      PieceBlock other(leaf, change);
      if (surface) other.radius = leaf.radius * change.quantum(leaf.scale);
      const PairReach pair_reach = reach_of(leaf, reach + other.slack + other.radius * kGrow, slack_ + other.slack);
      const std::uint32_t lanes = other.lanes;
      for (; near; near &= near - 1) {
        const int lane = std::countr_zero(near), piece = piece_of_lane(lane);
        if (once && index == block_) other.lanes = lanes & ~kLanesOfFirst[std::size_t(piece) + 1];
        const std::uint32_t found = near_piece(arrays, lane, other, pair_reach);
        if (found) add_candidates(pieces_[piece], leaf, found);
      }
    }

    /// The reach of pairs of pieces of the block and of a leaf; `slack` is that of both.
    PairReach reach_of(const WideLeaf& leaf, float reach, float slack) const {
      float size2 = 0.0f;
      for (int k = 0; k < 3; ++k) {
        const float side = box_.high[k] - box_.low[k];
        size2 += side * side;
      }
      const float longest = 255.0f * search_.second_change_.quantum(leaf.scale), leaf_size2 = 3.0f * longest * longest;
      const float apart = reach + sqrt(size2) + sqrt(leaf_size2);
      const float margin = 0x1p-19f * reach + 0.02f * slack;  // what other rounding leaves of the reach
      return {reach * reach, 0x1p-41f * size2 * leaf_size2 * apart * apart * (1.0f + 0.5f * reach / margin)};
    }

    void add_candidates(const Piece& piece, const WideLeaf& leaf, std::uint32_t lanes) {
      const WideRef* const refs = search_.second_.refs.data();
      for (; lanes; lanes &= lanes - 1) {
        const std::uint32_t ref = leaf.first_ref + std::uint32_t(piece_of_lane(std::countr_zero(lanes)));
        Candidate next{piece.prim, refs[ref].prim, piece.ref, ref};
        if (query_.is_self && next.i >= next.j) {
          if (next.i == next.j || search_.meets_twice()) continue;
          next = {next.j, next.i, next.ref_j, next.ref_i};
        }
        if (!query_.counts(next.i, next.j)) continue;
        if (search_.second_repeats_) {
          met_.reserve(1);
          if (!met_.insert(std::uint64_t(piece.prim) << 32 | refs[ref].prim)) continue;
        }
        __builtin_prefetch(query_.first.row(next.i));
        __builtin_prefetch(query_.second.row(next.j));
        candidates_[n_candidates_++] = next;
      }
      if (n_candidates_ > kMaxCandidates - kSimdWidth) test_candidates(kSimdWidth - 1);
    }

    /// Test candidates, 16 at a time, until at most this many are left.
    void test_candidates(std::uint32_t n_left) {
      std::uint32_t at = 0;
      for (; n_candidates_ - at > n_left && at < n_candidates_; at += kSimdWidth)
        test(candidates_ + at, std::min(n_candidates_ - at, std::uint32_t(kSimdWidth)));
      at = std::min(at, n_candidates_);
      std::copy(candidates_ + at, candidates_ + n_candidates_, candidates_);
      n_candidates_ -= at;
      to_.check(progress_);
    }

    void test(const Candidate* candidates, std::uint32_t n) {
      const float *rows_i[kSimdWidth], *rows_j[kSimdWidth];
      for (std::uint32_t lane = 0; lane < kSimdWidth; ++lane) {
        const Candidate& candidate = candidates[std::min(lane, n - 1)];
        rows_i[lane] = query_.first.row(candidate.i);
        rows_j[lane] = query_.second.row(candidate.j);
      }
      FloatX16 first[kAxisFields], second[kAxisFields];
      query_.first.load<surface>(rows_i, query_.frame, first);
      query_.second.load<surface>(rows_j, query_.frame, second);
      const NearestPair<FloatX16> found =
          nearest_pair<surface>(first, second, FloatX16(search_.radius_), FloatX16(search_.radius2_));
      std::uint32_t within = found.within.bits() & lane_mask(n);
      if (within == 0) return;
      float s[kSimdWidth], t[kSimdWidth], distance[kSimdWidth];
      found.s.store(s);
      found.t.store(t);
      found.distance.store(distance);
      for (; within; within &= within - 1) {
        const int lane = std::countr_zero(within);
        const Candidate& pair = candidates[lane];
        if (owned(search_.first_, pair.ref_i, s[lane]) && owned(search_.second_, pair.ref_j, t[lane]))
          to_.add({pair.i, pair.j, s[lane], t[lane], distance[lane] * search_.to_scene_});
      }
    }

    static bool owned(const PairTree& tree, std::uint32_t ref, float s) {
      if (ref == kNoRef) return true;
      const Reference piece = tree.refs[ref];
      return owns(piece.s0, piece.s1, s);
    }

    static constexpr std::uint32_t kMaxCandidates = 256;

    const PairSearch& search_;
    const PairQuery& query_;
    PairList::Part& to_;
    const Progress& progress_;
    Checkpoint checkpoint_;
    std::uint32_t block_ = 0;  // the block whose pairs are sought, its box and its pieces
    SearchBox box_;
    float slack_ = 0.0f;  // of the block's pieces
    Piece pieces_[kSimdWidth];
    std::vector<std::uint32_t> stack_;
    VisitedSetOf<std::uint64_t> met_;  // the pairs that the block has met, if leaves repeat primitives
    std::uint32_t n_candidates_ = 0;
    Candidate candidates_[kMaxCandidates];
  };

  const PairQuery& query_;
  const PairTree first_, second_;
  FrameChange change_, second_change_;  // of both trees
  float radius_, radius2_, to_scene_, reach_;
  std::vector<std::uint32_t> blocks_;      // of the first tree, near the second one
  std::vector<std::uint32_t> first_leaf_;  // the first of them with each primitive, if leaves repeat them
  bool second_repeats_;
};

}  // namespace fastlines
