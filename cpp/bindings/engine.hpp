// What a module for one instruction set holds.
#pragma once

#include <nanobind/nanobind.h>

namespace fastlines {

void define_engine(nanobind::module_& m);

}  // namespace fastlines
