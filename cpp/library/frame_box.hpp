// The box whose frame the queries of a tree compute in.
#pragma once

#include "core_values.hpp"
#include "engine.hpp"
#include "fastlines/tree/tree.hpp"
#include "line_input.hpp"

namespace fl::detail {

/// The box whose frame queries compute in. Throws InputError if it does not hold the tree's.
inline fastlines::Box frame_box_of(const TreeOrigin& origin, const fastlines::Tree& tree) {
  const fastlines::Box& box = tree.nodes[0].box;
  if (!origin.frame) return box;
  const auto& [x0, y0, z0, x1, y1, z1] = *origin.frame;
  const fastlines::Box frame{{x0, y0, z0}, {x1, y1, z1}};
  const bool is_box = is_valid(vector_of(frame.lo)) && is_valid(vector_of(frame.hi)) && !frame.is_empty();
  if (!is_box || !(tree.refs.empty() || frame.contains(box)))
    throw InputError("the lines leave the frame of the tree; build a tree with a larger frame");
  return frame;
}

}  // namespace fl::detail
