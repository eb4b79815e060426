// All of fastlines for C++ programs.
#pragma once

#include "build/builder.hpp"
#include "primitives/boxes.hpp"
#include "primitives/segments.hpp"
#include "primitives/triangles.hpp"
#include "query/batch.hpp"
#include "tree/validate.hpp"
