// Includes the whole core: templates for programs with primitives, queries or builders of their own.
#pragma once

#include "build/builder.hpp"
#include "build/refit.hpp"
#include "build/reinsertion.hpp"
#include "kernels/proximity/in_box.hpp"
#include "kernels/run/one_ray.hpp"
#include "kernels/run/run_batch.hpp"
#include "kernels/run/traverse.hpp"
#include "layout/collapse.hpp"
#include "primitives/shapes.hpp"
#include "query/binary_traversal.hpp"
#include "query/brute_force.hpp"
#include "query/for_each_ray.hpp"
#include "query/plane_traversal.hpp"
#include "tree/cost.hpp"
#include "tree/validate.hpp"
