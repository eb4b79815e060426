// The parts of an engine module: builds over segments, refits, and queries on the wide layout. The same sources are
// compiled for each instruction set. Each part is bound by its own source file, so that they compile in parallel. The
// types of the arguments are those of fastlines._core.
#pragma once

#include <nanobind/nanobind.h>

namespace fastlines {

void bind_build(nanobind::module_& m);
void bind_layout(nanobind::module_& m);
void bind_queries(nanobind::module_& m);
void bind_gather(nanobind::module_& m);
void bind_points(nanobind::module_& m);
void bind_pairs(nanobind::module_& m);
void bind_in_box(nanobind::module_& m);
void bind_routes(nanobind::module_& m);
void bind_frames(nanobind::module_& m);
void bind_hair(nanobind::module_& m);
void bind_paths(nanobind::module_& m);
void bind_looks(nanobind::module_& m);

/// Binds all parts.
void bind_engine(nanobind::module_& m);

}  // namespace fastlines
