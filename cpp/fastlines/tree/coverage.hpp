// Whether the leaves that list a primitive cover it, for primitives that are referenced as a whole.
//
// A region is cut along a side of a leaf's box until one leaf covers the part of the primitive in it. If no side is
// left to cut along, and no leaf covers the part, the leaves do not cover the primitive. The sides nearest to the
// middle of the region come first, so k leaves take about k·log k steps.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "../primitives/primitive.hpp"

namespace fastlines {

/// Checks the primitives of one set; its memory is reused.
template <Primitives P>
class Coverage {
 public:
  /// A part that rounding leaves outside of a leaf's box may lie within `slack` of the part inside.
  Coverage(const P& prims, double slack) : prims_(prims), slack_(slack) {}

  /// Whether the boxes of some leaves cover a primitive.
  bool operator()(std::uint32_t prim, std::span<const Box> leaves) {
    boxes_.assign(leaves.begin(), leaves.end());
    open_.assign(1, {prims_.bounds(prim), 0, boxes_.size()});
    while (!open_.empty()) {
      const Region region = open_.back();
      open_.pop_back();
      boxes_.resize(region.end);
      if (region.part.is_empty() || covered_by_one(prim, region)) continue;
      const auto [axis, plane] = middle_side(region);
      if (axis < 0) return false;
      for (const bool upper : {false, true}) {
        Box half = region.part;
        (upper ? half.lo : half.hi)[axis] = plane;
        half = prims_.clipped_bounds(prim, half);
        // Keep the boxes that meet the half, or nearly do.
        const std::size_t begin = boxes_.size();
        for (std::size_t i = region.begin; i < region.end; ++i)
          if (!intersection(grown(boxes_[i]), half).is_empty()) boxes_.push_back(boxes_[i]);
        open_.push_back({half, begin, boxes_.size()});
      }
    }
    return true;
  }

 private:
  /// The box of a part of the primitive, and the range of the boxes that meet it.
  struct Region {
    Box part;
    std::size_t begin, end;
  };
  struct Plane {
    int axis;
    float at;
  };

  bool covered_by_one(std::uint32_t prim, const Region& region) const {
    const std::span boxes = std::span(boxes_).subspan(region.begin, region.end - region.begin);
    for (const Box& box : boxes)
      if (box.contains(region.part)) return true;
    // Layouts bound only the part of the primitive in the leaf's box, if it is not empty.
    for (const Box& box : boxes) {
      if (!grown(box).contains(region.part)) continue;
      const Box part = prims_.clipped_bounds(prim, box);
      if (grown(part.is_empty() ? box : part).contains(region.part)) return true;
    }
    return false;
  }

  /// The side of a box that cuts the region and is nearest to its middle; the axis is -1 if there is none.
  Plane middle_side(const Region& region) const {
    Plane best{-1, 0.0f};
    double least = HUGE_VAL;
    for (std::size_t i = region.begin; i < region.end; ++i)
      for (int k = 0; k < 3; ++k)
        for (const float side : {boxes_[i].lo[k], boxes_[i].hi[k]}) {
          const double lo = region.part.lo[k], hi = region.part.hi[k];
          if (!(lo < side && side < hi)) continue;
          const double from_middle = std::abs((side - lo) / (hi - lo) - 0.5);
          if (from_middle < least) {
            least = from_middle;
            best = {k, side};
          }
        }
    return best;
  }

  Box grown(Box box) const {
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = float(box.lo[k] - slack_);
      box.hi[k] = float(box.hi[k] + slack_);
    }
    return box;
  }

  const P& prims_;
  double slack_;
  std::vector<Box> boxes_;
  std::vector<Region> open_;
};

}  // namespace fastlines
