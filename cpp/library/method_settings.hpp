// The settings of the named trees, as in Python's `fastlines.settings.methods`; a test compares the trees of both.
#pragma once

#include <algorithm>
#include <string>

#include "fastlines/api/tree.hpp"
#include "fastlines/build/settings.hpp"

namespace fl::detail {

inline constexpr std::size_t kMaxRefs = 0xffff'fff0;

/// A tree for fast queries.
inline fastlines::Settings query_settings(const fastlines::BinnedPlanes& planes) {
  return {.splits = {{planes}},
          .bad_levels = 3,
          .prune = false,
          .radius_hint = 0.001,
          .min_spread = 0.0005,
          .lanes = 16,
          .cost = {.c_trav = 4.0},
          .limits = {.max_leaf_refs = 16, .leaf_refs = 16}};
}

/// `best`: the tree that queries are fastest on.
inline fastlines::Settings best_settings(float effort) {
  using fastlines::BinnedPlanes;
  return query_settings(effort < 0.25f   ? BinnedPlanes{8, 128, 64, 0.6, 128, kMaxRefs, 0.85}
                        : effort < 0.75f ? BinnedPlanes{16, 128, 64, 0.6, 512, kMaxRefs, 0.8}
                                         : BinnedPlanes{effort < 0.875f ? 16 : 32, 128, 32, 0.0, 0, 0, 0.8});
}

/// `beams`: the least time of a build and one query.
inline fastlines::Settings beam_settings() { return query_settings({8, 128, 64, 0.6, 128, kMaxRefs, 0.85, 256.0}); }

/// Those of the thesis.
inline fastlines::Settings thesis_settings(Method method) {
  using enum Method;
  const bool is_kd = method == kd_cl || method == kd_d2, looks_ahead = method == bvh_d2 || method == kd_d2;
  const fastlines::SplitSet splits = method == bvh_cl ? fastlines::SplitSet(fastlines::ObjectSweep{})
                                                      : fastlines::SplitSet(fastlines::PlaneGrid{is_kd ? 12 : 8});
  return {.splits = {{splits}},
          .boxes = is_kd ? fastlines::BoxRule::cut : fastlines::BoxRule::tight,
          .lookahead = looks_ahead ? std::vector{1, 2} : std::vector{1},
          .cost = {.c_trav = is_kd ? 0.6 : 2.0}};
}

/// The name of a method in Python.
inline const char* method_name(Method method) {
  constexpr const char* names[] = {"best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2", "beams"};
  return names[int(method)];
}

inline fastlines::Settings method_settings(const BuildOptions& options, std::size_t n_prims) {
  constexpr std::size_t large = 1 << 18;
  if (options.method < Method::best || options.method > Method::beams)
    throw InputError("unknown method; expected one of fl::Method");
  if (options.effort && options.method != Method::best)
    throw InputError("an effort is for Method::best; leave it out, or choose that method");
  if (options.effort && !(*options.effort >= 0 && *options.effort <= 1))
    throw InputError("the effort is " + std::to_string(*options.effort) +
                     "; expected a number from 0, the fastest build, to 1, the best tree");
  fastlines::Settings settings = options.method == Method::best
                                     ? best_settings(options.effort.value_or(n_prims >= large ? 0.0f : 0.5f))
                                 : options.method == Method::beams ? beam_settings()
                                                                   : thesis_settings(options.method);
  settings.limits.max_refs = std::min(kMaxRefs, 1000 * n_prims + 10'000);
  return settings;
}

}  // namespace fl::detail
