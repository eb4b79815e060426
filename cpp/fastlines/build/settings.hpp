// The settings of a build (thesis §4.3): the cost model, SPLITS, the depth of the search, and limits.
#pragma once

#include "../references/presplit.hpp"
#include "../splits/split_set.hpp"

namespace fastlines {

/// The cost model. Only the ratio of the two matters (Theorem 2).
struct Cost {
  double c_trav = 2.0;  ///< of a traversal step, in any unit
  double c_prim = 1.0;  ///< of a test of one reference, in the same unit
};

struct Limits {
  std::size_t max_depth = 64;                   ///< the deepest level of any node; the root's is 0
  std::size_t max_leaf_refs = std::size_t(-1);  ///< larger nodes are split at any cost; tight boxes only
  std::size_t max_refs = 0xffff'fff0;           ///< references of the whole tree
  std::size_t leaf_refs = 1;                    ///< nodes of at most this many references are not split
  double leaf_size = 0.0;                       ///< nodes whose longest side is at most this long are not split
};

struct Settings {
  Splits splits{{PlaneGrid{}}};        ///< SPLITS of the thesis
  BoxRule boxes = BoxRule::tight;      ///< BVH or KD tree
  std::vector<int> lookahead{1};       ///< levels to search; the next is tried where the one before chooses a leaf
  std::size_t beam = std::size_t(-1);  ///< at most this many candidates of a node are searched more than one level deep
  bool exhaustive = false;             ///< search even candidates that cannot win; the tree is the same
  int bad_levels = 0;        ///< consecutive levels that may be split although no split looks better than a leaf
  std::size_t bad_refs = 0;  ///< only nodes of more than this many references may be split so
  int bad_refines = 0;       ///< levels of a path that may be split at the midpoint although the search chooses a leaf
  bool prune = true;         ///< turn a finished subtree into a leaf where it costs no less than the leaf
  double radius_hint = 0.0;  ///< the search measures boxes grown by this fraction of the scene's longest side
  /// No plane cuts retraced lines, which lie within this fraction of the scene's longest side around their mean.
  double min_spread = 0.0;
  std::size_t lanes = 1;   ///< references tested at once; a power of two
  Presplit presplit{};     ///< cut primitives before the build
  Cost cost{};             ///< in the search and in pruning
  Limits limits{};         ///< where the build stops splitting
  unsigned n_threads = 1;  ///< the tree does not depend on it
};

/// The number of nodes at which each limit narrowed the search or forced a split.
struct LimitsHit {
  std::size_t depth = 0, refs = 0, leaf_refs = 0;

  LimitsHit& operator+=(const LimitsHit& other) {
    depth += other.depth;
    refs += other.refs;
    leaf_refs += other.leaf_refs;
    return *this;
  }
};

/// How many candidates searches of more than one level considered, and for how many they partitioned the node.
struct SearchCounts {
  std::size_t candidates = 0, partitioned = 0;

  SearchCounts& operator+=(const SearchCounts& other) {
    candidates += other.candidates;
    partitioned += other.partitioned;
    return *this;
  }
};

}  // namespace fastlines
