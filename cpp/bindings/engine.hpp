// An engine: trees over segments, refits, and queries on the wide layout; the same sources compiled for each
// instruction set. Each part is bound by a source of its own, so that they compile at the same time. The types of the
// arguments are those of fastlines._core.
#pragma once

#include <nanobind/nanobind.h>

namespace fastlines {

void bind_build(nanobind::module_& m);
void bind_layout(nanobind::module_& m);
void bind_queries(nanobind::module_& m);

/// All of them.
void bind_engine(nanobind::module_& m);

}  // namespace fastlines
