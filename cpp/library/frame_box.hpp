// The box whose frame the queries of a tree compute in.
#pragma once

#include <cmath>

#include "engine.hpp"
#include "fastlines/tree/tree.hpp"

namespace fl::detail {

/// The box whose frame queries compute in. Throws InputError if it does not hold the tree's.
inline fastlines::Box frame_box_of(const TreeOrigin& origin, const fastlines::Tree& tree) {
  const fastlines::Box& box = tree.nodes[0].box;
  if (!origin.frame) return box;
  const auto& [x0, y0, z0, x1, y1, z1] = *origin.frame;
  const fastlines::Box frame{{x0, y0, z0}, {x1, y1, z1}};
  const bool is_finite = std::ranges::all_of(*origin.frame, [](float x) { return std::isfinite(x); });
  if (!is_finite || !(tree.refs.empty() || frame.contains(box)))
    throw InputError("the lines leave the frame of the tree; build a tree with a larger frame");
  return frame;
}

}  // namespace fl::detail
