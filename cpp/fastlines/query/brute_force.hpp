// Tests every primitive with a ray: the reference for the answers of all trees.
#pragma once

#include <algorithm>
#include <span>

#include "../parallel/progress.hpp"
#include "test_primitive.hpp"

namespace fastlines {

/// Tests all primitives in order of their ids, each as a whole.
template <RayPrimitive P>
struct BruteForce {
  static constexpr bool kTestsAll = true;

  struct Scratch {
    Checkpoint* checkpoint = nullptr;
  };

  P prims;
  Frame frame;

  template <RayCollector C>
  void operator()(const RayOf<P>& ray, C& to, Scratch& scratch) const {
    constexpr std::size_t at_once = 1024;  // primitives between two checkpoints
    for (std::size_t first = 0; first < prims.size(); first += at_once) {
      const std::size_t end = std::min(first + at_once, prims.size());
      if (scratch.checkpoint) scratch.checkpoint->pass(end - first);
      for (std::size_t prim = first; prim < end; ++prim)
        if (test_primitive(prims, ray, frame, Reference{std::uint32_t(prim)}, to)) return;
    }
  }
};

}  // namespace fastlines
