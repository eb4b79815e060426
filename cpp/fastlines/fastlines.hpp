// The C++ interface of the library: build a tree over lines, then query it with rays. Link with fastlines::fastlines.
//
//     const std::vector<fl::Segment> lines{{{-1, -1, -1}, {1, 1, 1}}};
//     const fl::Tree tree = fl::build(lines);
//     if (const fl::Hit hit = tree.first_hit({{0, 0, -5}, {0, 0, 1}}, 0.5f)) std::printf("line %d\n", int(hit.prim));
//
// Programs with primitives of their own include "core.hpp".
#pragma once

#include "api/acc_tree.hpp"
#include "api/tree.hpp"
