// The settings of a build as Python classes, with keyword arguments. Defaults are in Python.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include "fastlines/build/settings.hpp"
#include "sequences.hpp"

namespace fastlines {

inline BoxRule box_rule(const std::string& boxes) {
  if (boxes == "tight") return BoxRule::tight;
  if (boxes == "cut") return BoxRule::cut;
  throw std::invalid_argument("unknown rule for boxes: " + boxes);
}

inline void bind_split_sets(nanobind::module_& m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  nb::class_<ObjectSweep>(m, "ObjectSweep").def(nb::init<>());
  nb::class_<PlaneEvents>(m, "PlaneEvents").def(nb::init<>());
  nb::class_<Median>(m, "Median").def(nb::init<>());
  nb::class_<Midpoint>(m, "Midpoint").def(nb::init<>());
  nb::class_<PlaneGrid>(m, "PlaneGrid")
      .def("__init__", [](PlaneGrid* self, int n_planes) { new (self) PlaneGrid{n_planes}; }, "n_planes"_a);
  nb::class_<BinnedPlanes>(m, "BinnedPlanes")
      .def(
          "__init__",
          [](BinnedPlanes* self, int n_planes, std::size_t uncut_refs, std::size_t uncut_only_refs, double max_overlap,
             std::size_t sample, std::size_t gap_refs, double gap, double uncut_only_side) {
            new (self) BinnedPlanes{n_planes, uncut_refs, uncut_only_refs, max_overlap, sample,
                                    gap_refs, gap,        uncut_only_side};
          },
          nb::kw_only(), "n_planes"_a, "uncut_refs"_a, "uncut_only_refs"_a, "max_overlap"_a, "sample"_a, "gap_refs"_a,
          "gap"_a, "uncut_only_side"_a);
  nb::class_<SizedSplitSet>(m, "SizedSplitSet")
      .def(
          "__init__",
          [](SizedSplitSet* self, const SplitSet& set, std::size_t max_refs, double min_overlap) {
            new (self) SizedSplitSet{set, max_refs, min_overlap};
          },
          "set"_a, nb::kw_only(), "max_refs"_a, "min_overlap"_a);
}

inline void bind_settings(nanobind::module_& m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  bind_split_sets(m);
  nb::class_<Limits>(m, "Limits")
      .def(
          "__init__",
          [](Limits* self, std::size_t max_depth, std::size_t max_leaf_refs, std::size_t max_refs,
             std::size_t leaf_refs,
             double leaf_size) { new (self) Limits{max_depth, max_leaf_refs, max_refs, leaf_refs, leaf_size}; },
          nb::kw_only(), "max_depth"_a, "max_leaf_refs"_a, "max_refs"_a, "leaf_refs"_a, "leaf_size"_a);
  nb::class_<Presplit>(m, "Presplit")
      .def(
          "__init__", [](Presplit* self, double area, std::size_t max_refs) { new (self) Presplit{area, max_refs}; },
          nb::kw_only(), "area"_a, "max_refs"_a);
  nb::class_<Settings>(m, "Settings")
      .def(
          "__init__",
          [](Settings* self, Sequence<SizedSplitSet> splits, const std::string& boxes, Sequence<int> lookahead,
             std::size_t beam, bool exhaustive, double c_trav, double c_prim, std::size_t lanes, const Limits& limits,
             int bad_levels, std::size_t bad_refs, int bad_refines, bool prune, double radius_hint, double min_spread,
             const Presplit& presplit, unsigned n_threads) {
            new (self) Settings{.splits = vector_of<SizedSplitSet>(splits),
                                .boxes = box_rule(boxes),
                                .lookahead = vector_of<int>(lookahead),
                                .beam = beam,
                                .exhaustive = exhaustive,
                                .bad_levels = bad_levels,
                                .bad_refs = bad_refs,
                                .bad_refines = bad_refines,
                                .prune = prune,
                                .radius_hint = radius_hint,
                                .min_spread = min_spread,
                                .lanes = lanes,
                                .presplit = presplit,
                                .cost = {c_trav, c_prim},
                                .limits = limits,
                                .n_threads = n_threads};
          },
          nb::kw_only(), "splits"_a, "boxes"_a, "lookahead"_a, "beam"_a, "exhaustive"_a, "c_trav"_a, "c_prim"_a,
          "lanes"_a, "limits"_a, "bad_levels"_a, "bad_refs"_a, "bad_refines"_a, "prune"_a, "radius_hint"_a,
          "min_spread"_a, "presplit"_a, "n_threads"_a);
}

}  // namespace fastlines
