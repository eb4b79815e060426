// The parts of the module fastlines._core. Each is bound by its own source file, so that they compile in parallel.
#pragma once

#include <nanobind/nanobind.h>

namespace fastlines {

void bind_trees(nanobind::module_& m);
void bind_checks(nanobind::module_& m);
void bind_binary_queries(nanobind::module_& m);
void bind_pairs(nanobind::module_& m);
void bind_in_box(nanobind::module_& m);
void bind_merges(nanobind::module_& m);
void bind_top_tree(nanobind::module_& m);
void bind_forest(nanobind::module_& m);

}  // namespace fastlines
