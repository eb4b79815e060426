// Tests every primitive with a ray: the reference for the answers of all trees.
#pragma once

#include <span>

#include "test_primitive.hpp"

namespace fastlines {

/// Tests all primitives in order of their ids, each as a whole.
template <RayPrimitive P>
struct BruteForce {
  static constexpr bool kTestsAll = true;

  struct Scratch {};

  P prims;
  Frame frame;

  template <RayCollector C>
  void operator()(const RayOf<P>& ray, C& to, Scratch&) const {
    for (std::size_t prim = 0; prim < prims.size(); ++prim)
      if (test_primitive(prims, ray, frame, Reference{std::uint32_t(prim)}, to)) return;
  }
};

}  // namespace fastlines
