// The primitives that kernels know: how one is read, and its exact test.
#pragma once

#include "../primitives/axis_fields.hpp"
#include "../primitives/round_cone_test.hpp"
#include "../primitives/segment_test.hpp"
#include "../primitives/shape_test.hpp"
#include "../rays/spread_ray.hpp"

namespace fastlines {

/// Segments, as rows of six floats.
struct DeviceSegments {
  static constexpr int kFloats = 6;
  static constexpr bool kHasRadius = false;  ///< whether leaves of axes are culled by the radius of their primitives
  static constexpr bool kHasBoxes = false;   ///< whether leaves may store boxes; pieces then do not own hits
  using Test = SegmentTest<float, Ray>;

  static std::array<float, 6> fields(const float (&floats)[6], const Frame& frame) {
    return segment_fields(floats, frame);
  }
};

/// Round cones, as rows of eight floats.
struct DeviceRoundCones {
  static constexpr int kFloats = 8;
  static constexpr bool kHasRadius = true, kHasBoxes = false;
  using Test = RoundConeTest<float, Ray>;

  static std::array<float, 8> fields(const float (&floats)[8], const Frame& frame) {
    return round_cone_fields(floats, frame);
  }
};

/// Round cones for rays with a spread.
struct DeviceSpreadCones : DeviceRoundCones {
  static constexpr bool kHasSpread = true;
  using Test = RoundConeTest<float, SpreadRay>;
};

/// Shapes: round cones, triangles and boxes, as rows of ten floats.
struct DeviceShapes {
  static constexpr int kFloats = kShapeFields;
  static constexpr bool kHasRadius = true, kHasBoxes = true;
  using Test = ShapeTest<float, Ray>;

  static std::array<float, kShapeFields> fields(const float (&floats)[kShapeFields], const Frame& frame) {
    return shape_fields(floats, frame);
  }
};

/// The exact test of a ray and a primitive, given as the first of its floats. It must not outlive the ray.
template <class P>
[[gnu::always_inline]] inline typename P::Test device_test(const RayOf<P>& ray, const float* item, const Frame& frame) {
  float floats[P::kFloats];
  for (int i = 0; i < P::kFloats; ++i) floats[i] = item[i];
  return {ray, P::fields(floats, frame)};
}

}  // namespace fastlines
