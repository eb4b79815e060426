// Culls the root's children for a packet of rays at a time. Every incoherent ray starts there, so no ray needs to be
// gathered or compressed: passing the root takes half as long as another step.
#pragma once

#include "node_cull.hpp"

namespace fastlines {

/// The boxes of the root's children, decoded from bytes to floats.
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

  /// Whether rays may start at the root's children: there is at least one, and none is a leaf.
  bool has_inner_only() const { return n_children_ > 0; }

  std::uint32_t first_child() const { return first_child_; }

  /// The result for a packet.
  struct Hits {
    /// [child][ray]: where the ray enters the child, t in the frame, or infinity if it does not.
    alignas(64) float enter[kSimdWidth][kSimdWidth];
    alignas(64) float children[kSimdWidth];  // per ray: the mask of the children that it hits, converted to float
    alignas(64) float nearest[kSimdWidth];   // per ray: the child that it enters first, converted to float

    std::uint32_t children_of(int ray) const { return std::uint32_t(std::int32_t(children[ray])); }
  };

  /// Find the children that each ray of a packet may hit before its limit. Sets `enter` and `nearest` only with
  /// `nearest_first`.
  template <bool nearest_first>
  [[gnu::always_inline]] void cull(const CullRayOf<FloatX16>& rays, FloatX16 limit, Hits& hits) const {
    using F = FloatX16;
    const F zero = 0.0f, never = kInfinity;
    // Swap near and far for negative directions.
    F to_low[3], to_high[3];
    for (int k = 0; k < 3; ++k) {
      const auto back = rays.inverse[k] < zero;
      to_low[k] = blend(back, rays.far[k], rays.near[k]);
      to_high[k] = blend(back, rays.near[k], rays.far[k]);
    }
    // Test one child at a time.
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
  float low_[3][kSimdWidth], high_[3][kSimdWidth];  // the planes of the boxes: [axis][child]
};

}  // namespace fastlines
