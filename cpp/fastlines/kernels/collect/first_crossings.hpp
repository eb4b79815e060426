// Joins the pieces that rays hit first into crossings (query/crossings.hpp), while rays are traced.
#pragma once

#include <algorithm>
#include <vector>

#include "../../layout/wide_bvh.hpp"
#include "../../query/crossings.hpp"

namespace fastlines {

/// The crossings of a batch of rays with primitives in pieces; one per thread.
template <RayPrimitive P>
class FirstCrossings {
 public:
  FirstCrossings(const WideBvhView<P>& tree, const RayBatch& rays, PieceOwners owners, At at)
      : rays_(rays), finder_(tree.items, tree.frame, owners, at) {}

  /// Whether a hit of a ray and a piece begins a crossing.
  bool operator()(std::uint32_t ray, std::uint32_t piece) { return beginning_with(ray, piece) != nullptr; }

  /// The crossing of a ray that begins with this piece; null if there is none.
  const Hit* beginning_with(std::uint32_t ray, std::uint32_t piece) {
    const std::int64_t listed = piece;
    finder_.find(rays_[ray], {&listed, 1}, false, found_);
    const auto first = std::find_if(found_.begin(), found_.end(), [=](const Hit& hit) { return hit.prim == listed; });
    return first == found_.end() ? nullptr : &*first;
  }

 private:
  const RayBatch& rays_;
  CrossingFinder<P> finder_;
  std::vector<Hit> found_;
};

}  // namespace fastlines
