// What a build is told, as Python says it, and the arrays that come of it.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "fastlines/build/builder.hpp"
#include "watch.hpp"

namespace fastlines {

inline BoxRule box_rule(bool cut) { return cut ? BoxRule::cut : BoxRule::tight; }

/// What octets of planes are told besides their number.
using OctetArgs = std::tuple<std::size_t, std::size_t, double, std::size_t, std::size_t, double>;

inline SplitSet split_set(const std::string& name, int n_planes, const OctetArgs& octets) {
  const auto& [uncut_up_to, only_uncut_up_to, max_overlap, sample, gap_up_to, apart] = octets;
  if (name == "object_sweep") return ObjectSweep{};
  if (name == "plane_grid") return PlaneGrid{n_planes};
  if (name == "plane_octets")
    return BinnedPlanes{n_planes, uncut_up_to, only_uncut_up_to, max_overlap, sample, gap_up_to, apart};
  if (name == "plane_events") return PlaneEvents{};
  if (name == "median") return Median{};
  if (name == "middle") return Midpoint{};
  throw std::invalid_argument("unknown split set: " + name);
}

/// Name, planes, octets, largest nodes that are asked about, least overlap.
using SplitSetArgs = std::tuple<std::string, int, OctetArgs, std::size_t, double>;

/// The fields of `Settings` in Python, in their order, the search, costs and lanes, limits, bad levels and refines, and
/// presplit as tuples of their own; then threads.
using SettingsArgs =
    std::tuple<std::vector<SplitSetArgs>, bool, std::tuple<std::vector<int>, std::size_t, bool>,
               std::tuple<double, double, std::size_t>,
               std::tuple<std::size_t, std::size_t, std::size_t, std::size_t, double>,
               std::tuple<int, std::size_t, int>, bool, double, double, std::pair<double, std::size_t>, unsigned>;

inline Settings settings_of(const SettingsArgs& args) {
  const auto& [splits, cut, search, cost, limits, bad, prune, radius_hint, min_spread, presplit, n_threads] = args;
  Settings settings;
  settings.splits.clear();
  for (const auto& [name, n_planes, octets, max_refs, min_overlap] : splits)
    settings.splits.push_back({split_set(name, n_planes, octets), max_refs, min_overlap});
  settings.boxes = box_rule(cut);
  std::tie(settings.lookahead, settings.beam, settings.exhaustive) = search;
  std::tie(settings.cost.c_trav, settings.cost.c_prim, settings.lanes) = cost;
  const auto& [max_depth, max_leaf_refs, max_refs, leaf_refs, leaf_size] = limits;
  settings.limits = {max_depth, max_leaf_refs, max_refs, leaf_refs, leaf_size};
  std::tie(settings.bad_levels, settings.bad_refs, settings.bad_refines) = bad;
  settings.prune = prune;
  settings.radius_hint = radius_hint;
  settings.min_spread = min_spread;
  settings.presplit = {presplit.first, presplit.second};
  settings.n_threads = n_threads;
  return settings;
}

/// Nodes, references, at how many nodes each limit was felt, and how many candidates were looked into and carried out.
template <Primitives P>
nanobind::tuple build_tree(const P& prims, const SettingsArgs& args, const nanobind::object& progress) {
  Settings settings = settings_of(args);
  Tree tree;
  LimitsHit hit;
  Searched searched;
  watch(
      [&](Progress& watched) {
        for (SizedSplitSet& sized : settings.splits)
          if (sized.min_overlap > 0.0) sized.min_overlap *= bounds_of_all(prims).area();
        Builder builder(prims, settings, watched);
        tree = builder.build();
        hit = builder.limits_hit();
        searched = builder.searched();
      },
      progress);
  return nanobind::make_tuple(adopt<std::uint32_t>(std::move(tree.nodes)), adopt<std::uint32_t>(std::move(tree.refs)),
                              nanobind::make_tuple(hit.depth, hit.refs, hit.leaf_refs),
                              nanobind::make_tuple(searched.candidates, searched.carried_out));
}

}  // namespace fastlines
