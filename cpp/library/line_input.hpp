// Lines as the core takes them: checked copies, and their axes.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "fastlines/api/tree.hpp"
#include "fastlines/primitives/round_cones.hpp"
#include "fastlines/primitives/segments.hpp"
#include "method_settings.hpp"

namespace fl::detail {

/// The same array as another type of the same floats in the same order.
template <class To, class From>
std::span<const To> view_as(std::span<const From> items) {
  static_assert(sizeof(To) == sizeof(From) && alignof(To) == alignof(From));
  return {reinterpret_cast<const To*>(items.data()), items.size()};
}

/// Beyond this, squares of coordinates would overflow in the builder.
inline constexpr float kCoordinateLimit = 1e30f;

inline bool is_valid(const Vec3& v) {
  return std::fabs(v.x) <= kCoordinateLimit && std::fabs(v.y) <= kCoordinateLimit && std::fabs(v.z) <= kCoordinateLimit;
}
inline bool is_valid(float radius) { return radius >= 0 && radius <= kCoordinateLimit; }

/// Copies lines into the core's form. Throws InputError for the first one that cannot be used.
template <class To, class From>
std::vector<To> checked_copy(std::span<const From> lines) {
  if (!lines.data() && !lines.empty())
    throw InputError("the array of lines is null; expected a pointer to " + std::to_string(lines.size()) + " lines");
  if (lines.size() > kMaxRefs)
    throw InputError(std::to_string(lines.size()) + " lines are more than a tree can index; build several trees");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto fail = [&](const char* what) { throw InputError("line " + std::to_string(i) + " has " + what); };
    if (!is_valid(lines[i].p) || !is_valid(lines[i].q)) fail("a coordinate that is not a number from −1e30 to 1e30");
    if constexpr (std::is_same_v<From, RoundCone>)
      if (!is_valid(lines[i].radius_p) || !is_valid(lines[i].radius_q))
        fail("a radius that is not a number from 0 to 1e30");
  }
  const auto from = view_as<To>(lines);
  return {from.begin(), from.end()};
}

/// The axes of lines, which trees are over.
inline std::vector<fastlines::Segment> axes_of(std::span<const fastlines::RoundCone> cones) {
  std::vector<fastlines::Segment> axes;
  axes.reserve(cones.size());
  for (const auto& cone : cones) axes.push_back(cone.axis);
  return axes;
}
inline std::span<const fastlines::Segment> axes_of(std::span<const fastlines::Segment> segments) { return segments; }

}  // namespace fl::detail
