// Rays with a spread, and rays that leave out some lines. They are traced one at a time: the collectors of one ray get
// what the traversal of the layout reports, without what is left out.
#pragma once

#include "fastlines/kernels/run/traverse.hpp"
#include "fastlines/query/for_each_ray.hpp"
#include "ignored.hpp"

namespace fl::detail {

/// A search of the layout for one ray, as `for_each_ray` takes it. Reports what is not left out.
template <fastlines::AxisPrimitive P>
struct LayoutSearch {
  const fastlines::WideBvhView<P>& tree;
  const P& prims;
  const Ignored& ignored;
  const fastlines::Frame& frame = tree.frame;
  struct Scratch {
    fastlines::Checkpoint* checkpoint = nullptr;
  };

  void operator()(const fastlines::RayOf<P>& ray, fastlines::RayCollectorRef& to, Scratch& scratch) const {
    Kept kept{to.at, to.limit, to, ignored};
    fastlines::traverse(tree, ray, kept, scratch.checkpoint);
  }

 private:
  /// Passes on the hits that are kept.
  struct Kept {
    static constexpr bool kShrinksLimit = true, kDropsFarther = false;
    const fastlines::At at;
    const float& limit;
    const fastlines::RayCollectorRef& to;
    const Ignored& ignored;

    void add(const fastlines::ClosestApproach<float>& approach, const fastlines::Reference& ref) const {
      if (!ignored.drops(ref.prim)) to.add(approach, ref);
    }
  };
};

}  // namespace fl::detail
