// The parts of the module fastlines._core, each bound by a source of its own, so that they compile at the same time.
#pragma once

#include <nanobind/nanobind.h>

namespace fastlines {

void bind_trees(nanobind::module_& m);
void bind_checks(nanobind::module_& m);
void bind_binary_queries(nanobind::module_& m);

}  // namespace fastlines
