// What a build can be told (thesis §4.3): the cost model, SPLITS, how deep to look ahead, and limits.
#pragma once

#include "../references/presplit.hpp"
#include "../splits/split_set.hpp"

namespace fastlines {

/// Only the ratio of the two matters (Theorem 2).
struct Cost {
  double c_trav = 2.0;
  double c_prim = 1.0;
};

struct Limits {
  std::size_t max_depth = 64;                   ///< level of the deepest node; the root's is 0
  std::size_t max_leaf_refs = std::size_t(-1);  ///< larger nodes are split though it looks dearer; tight boxes only
  std::size_t max_refs = 0xffff'fff0;           ///< of the whole tree
  std::size_t leaf_refs = 1;                    ///< nodes of this few references are not split
  double leaf_size = 0.0;                       ///< nodes whose longest side is no longer are not split
};

struct Settings {
  Splits splits{{PlaneGrid{}}};
  BoxRule boxes = BoxRule::tight;
  std::vector<int> lookahead{1};       ///< each is tried where the one before says leaf
  std::size_t beam = std::size_t(-1);  ///< of a node's candidates so many are looked into more than one level deep
  bool exhaustive = false;             ///< look into all of them, also where that can not pay; the tree is the same
  int bad_levels = 0;        ///< how many levels in a row may be split though that looks no better than a leaf
  std::size_t bad_refs = 0;  ///< but none below nodes of so many references
  int bad_refines = 0;       ///< how many levels of a path may be cut in the middle though the search says leaf
  bool prune = true;         ///< take back what bad levels did not pay for
  double radius_hint = 0.0;  ///< the search measures boxes grown by this much of the scene's longest side
  double min_spread = 0.0;   ///< no plane cuts most lines where all lie within so much of the scene's longest side
  std::size_t lanes = 1;     ///< a power of two: references are tested so many at once
  Presplit presplit;         ///< cut primitives before the build
  Cost cost;
  Limits limits;
  unsigned n_threads = 1;  ///< the tree does not depend on it
};

/// At how many nodes a limit narrowed the search, or forced a split.
struct LimitsHit {
  std::size_t depth = 0, refs = 0, leaf_refs = 0;

  LimitsHit& operator+=(const LimitsHit& other) {
    depth += other.depth;
    refs += other.refs;
    leaf_refs += other.leaf_refs;
    return *this;
  }
};

/// How many candidates were looked at more than one level deep, and how many of them carried out.
struct Searched {
  std::size_t candidates = 0, carried_out = 0;

  Searched& operator+=(const Searched& other) {
    candidates += other.candidates;
    carried_out += other.carried_out;
    return *this;
  }
};

}  // namespace fastlines
