// The root's children beside sixteen rays at once. Every ray that goes alone begins there, so that nothing has to be
// picked or packed for each: to come past the root takes half of what a step takes.
#pragma once

#include <limits>

#include "node_cull.hpp"

namespace fastlines {

class RootCull {
 public:
  template <RayPrimitive P>
  explicit RootCull(const WideBvhView<P>& tree) {
    const WideNode& root = tree.nodes[0];
    if (root.n_inner < root.n_children) return;
    first_child_ = root.first_inner;
    n_children_ = root.n_inner;
    for (int k = 0; k < 3; ++k)
      for (int child = 0; child < n_children_; ++child) {
        const auto plane = [&](int row) {
          return root.org[k] + float(root.planes[row * kSimdWidth + child]) * root.scale;
        };
        low_[k][child] = plane(k);
        high_[k][child] = plane(k + 3);
      }
  }

  /// Whether rays may begin at its children: at least one, none of which is a leaf.
  bool has_inner_only() const { return n_children_ > 0; }

  std::uint32_t first_child() const { return first_child_; }

  /// What sixteen rays cull.
  struct Hits {
    alignas(64) float enter[kSimdWidth]
                           [kSimdWidth];     // of each child, where each ray enters it, or infinity where it does not
    alignas(64) float children[kSimdWidth];  // of each ray, the children that it meets: their bits, as a number
    alignas(64) float nearest[kSimdWidth];   // and the one that it enters first

    std::uint32_t children_of(int ray) const { return std::uint32_t(std::int32_t(children[ray])); }
  };

  /// The children that rays may cull before their limits; without `nearest_first` not where, nor which comes first.
  template <bool nearest_first>
  [[gnu::always_inline]] void cull(const CullRayOf<FloatX16>& rays, FloatX16 limit, Hits& hits) const {
    using F = FloatX16;
    const F zero = 0.0f, never = std::numeric_limits<float>::infinity();
    F to_low[3], to_high[3];
    for (int k = 0; k < 3; ++k) {
      const auto back = rays.inverse[k] < zero;
      to_low[k] = blend(back, rays.far[k], rays.near[k]);
      to_high[k] = blend(back, rays.near[k], rays.far[k]);
    }
    F first = never, nearest = zero, children = zero;
    for (int child = 0; child < n_children_; ++child) {
      F near = rays.t_min, far = limit;
      for (int k = 0; k < 3; ++k) {
        const F low = fma(F(low_[k][child]), rays.inverse[k], to_low[k]);
        const F high = fma(F(high_[k][child]), rays.inverse[k], to_high[k]);
        near = max(near, min(low, high));
        far = min(far, max(low, high));
      }
      const auto is_hit = near <= far;
      children = children + blend(is_hit, F(float(1 << child)), zero);
      if constexpr (nearest_first) {
        const F enter = blend(is_hit, near, never);
        enter.store(hits.enter[child]);
        nearest = blend(enter < first, F(float(child)), nearest);
        first = min(enter, first);
      }
    }
    children.store(hits.children);
    if constexpr (nearest_first) {
      nearest.store(hits.nearest);
      for (int child = n_children_; child < kSimdWidth; ++child) never.store(hits.enter[child]);
    }
  }

 private:
  std::uint32_t first_child_ = 0;
  int n_children_ = 0;
  float low_[3][kSimdWidth], high_[3][kSimdWidth];  // the planes of their boxes
};

}  // namespace fastlines
