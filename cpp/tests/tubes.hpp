// Segments with a radius each.
#pragma once

#include <algorithm>

#include "fastlines/primitives/segment_test.hpp"

namespace fastlines {

struct Tube {
  Segment axis;
  float radius;
};

/// The test of a tube: the test of its axis, for a ray whose radius is larger by the tube's.
template <class N, class R>
class TubeTest {
 public:
  template <class V>
  [[gnu::always_inline]] TubeTest(const R& ray, const V& fields)
      : ray_(ray, N(fields[6])), test_(ray_, fields), closest(test_.closest) {}
  TubeTest(const TubeTest&) = delete;  // test_ refers to ray_

  [[gnu::always_inline]] ClosestApproach<N> entry() const { return test_.entry(); }
  [[gnu::always_inline]] N exit() const { return test_.exit(); }
  [[gnu::always_inline]] MaskOf<N> enters(const ClosestApproach<N>& entry) const { return test_.enters(entry); }

 private:
  GrownRay<N, R> ray_;
  SegmentTest<N, GrownRay<N, R>> test_;

 public:
  ClosestApproach<N> closest;
};

class Tubes {
 public:
  using Item = Tube;
  static constexpr const char* kKind = "tubes";
  static constexpr int kFields = 7;  // start, end − start, radius
  static constexpr bool kHasRadius = true;

  explicit Tubes(std::span<const Tube> tubes) : tubes_(tubes) {
    for (const Tube& tube : tubes) max_radius_ = std::max(max_radius_, tube.radius);
  }

  // For builders: the axes.
  std::size_t size() const { return tubes_.size(); }
  const Segment& curve(std::uint32_t prim) const { return tubes_[prim].axis; }
  Box bounds(std::uint32_t prim) const { return tubes_[prim].axis.bounds(); }
  Box clipped_bounds(std::uint32_t prim, const Box& box) const { return tubes_[prim].axis.clipped_bounds(box); }

  // For the fast path.
  const Tube* items() const { return tubes_.data(); }
  const Tube& item(std::uint32_t prim) const { return tubes_[prim]; }
  static const Segment& axis(const Tube& tube) { return tube.axis; }
  static float radius(const Tube& tube) { return tube.radius; }
  float max_radius() const { return max_radius_; }

  template <class N, class Frame>
  [[gnu::always_inline]] static std::array<N, kFields> fields(const N (&floats)[7], const Frame& frame) {
    const N ends[6] = {floats[0], floats[1], floats[2], floats[3], floats[4], floats[5]};
    const auto [x, y, z, u, v, w] = Segments::fields(ends, frame);
    return {x, y, z, u, v, w, floats[6] * N(frame.scale)};
  }
  template <class N>
  static N frame_radius(const std::array<N, kFields>& fields) {
    return fields[6];
  }
  template <class N, class R, class V>
  [[gnu::always_inline]] static TubeTest<N, R> test(const R& ray, const V& fields) {
    return {ray, fields};
  }

 private:
  std::span<const Tube> tubes_;
  float max_radius_ = 0.0f;
};
static_assert(AxisPrimitive<Tubes>);

}  // namespace fastlines
