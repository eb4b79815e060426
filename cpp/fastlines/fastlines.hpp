// All of fastlines for C++ programs.
#pragma once

#include "build/builder.hpp"
#include "build/reinsertion.hpp"
#include "kernels/run.hpp"
#include "layout/collapse.hpp"
#include "primitives/boxes.hpp"
#include "primitives/segments.hpp"
#include "primitives/triangles.hpp"
#include "query/lists.hpp"
#include "query/plane_search.hpp"
#include "tree/cost.hpp"
#include "tree/refit.hpp"
#include "tree/validate.hpp"
