// Tests every primitive with a ray: the reference for the answers of all trees.
#pragma once

#include <span>

#include "sinks.hpp"

namespace fastlines {

/// Tests all primitives in order of their ids, each as a whole.
template <RayPrimitive P>
struct BruteForce {
  static constexpr bool kTestsAll = true;

  struct Scratch {};

  P prims;
  Frame frame;

  template <class Sink>
  void operator()(const RayOf<P>& ray, Sink& sink, Scratch&) const {
    for (std::size_t prim = 0; prim < prims.size(); ++prim) {
      test_primitive(prims, ray, frame, Reference{std::uint32_t(prim)}, sink);
      if (sink.done()) return;
    }
  }
};

}  // namespace fastlines
