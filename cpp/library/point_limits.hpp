// Checks of points, and what is wrong with those that are not valid: as in Python.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "fastlines/api/tree.hpp"
#include "fastlines/math/box.hpp"

namespace fl::detail {

/// What points and radii may be, for the lines of a tree.
class PointLimits {
 public:
  /// The box of the axes, and the largest radius.
  PointLimits(const fastlines::Box& box, float max_radius) {
    constexpr double sizes = 1e12, most = std::numeric_limits<float>::max();
    if (box.is_empty()) return;
    double side = 0.0;
    for (int k = 0; k < 3; ++k) {
      low_[k] = box.lo[k] - max_radius;
      high_[k] = box.hi[k] + max_radius;
      side = std::max(side, high_[k] - low_[k]);
    }
    largest_ = std::min(sizes * (side > 0.0 ? side : 1.0), most);
    farthest_ = largest_;
  }

  /// The largest radius of a query.
  double largest() const { return largest_; }

  /// What is wrong with a point, less the offset; empty if nothing is.
  std::string fault(const Vec3d& point) const {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z))
      return "a coordinate that is not finite";
    return is_near(point) ? std::string() : "a place farther from the scene than " + text(farthest_);
  }
  std::string fault_of_radius(float radius) const {
    if (radius >= 0.0f && double(radius) <= largest_) return {};
    return "a radius of " + text(radius) + ", which is not a number from 0 to " + text(largest_);
  }
  static std::string fault_of_max_distance(float distance) {
    if (distance >= 0.0f) return {};
    return "a max_distance of " + text(distance) + ", which is not a number from 0 up";
  }

 private:
  /// Whether all corners of the scene are near enough. NaN is not near.
  bool is_near(const Vec3d& point) const {
    const double at[3] = {point.x, point.y, point.z};
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double farther = std::fmax(std::fabs(at[k] - low_[k]), std::fabs(at[k] - high_[k]));
      sum += farther * farther;
    }
    return std::sqrt(sum) <= farthest_;
  }

  static std::string text(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
  }

  double low_[3] = {}, high_[3] = {};
  double largest_ = 1e12, farthest_ = std::numeric_limits<float>::max();
};

}  // namespace fl::detail
