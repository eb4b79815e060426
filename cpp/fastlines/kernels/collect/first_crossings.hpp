// Joins the pieces that rays hit first into crossings (query/crossings.hpp), while rays are traced.
#pragma once

#include <vector>

#include "../../layout/wide_bvh.hpp"
#include "../../query/crossings.hpp"
#include "../rays/ray_group.hpp"

namespace fastlines {

/// The crossings of a batch of rays with primitives in pieces; one per thread.
template <RayPrimitive P>
class FirstCrossings {
 public:
  FirstCrossings(const WideBvhView<P>& tree, const RayBatch& rays, PieceOwners owners, At at)
      : rays_(rays), owners_(owners), finder_(tree.items, tree.frame, owners, at) {}

  /// Whether a hit of a ray and a piece begins the first crossing of the ray with the primitive of the piece.
  bool operator()(std::uint32_t ray, std::uint32_t piece) { return first_with(ray, piece).prim == std::int64_t(piece); }

  /// The first crossing of a ray with the primitive that this is a piece of; a miss if there is none.
  const Hit& first_with(std::uint32_t ray, std::uint32_t piece) {
    Known& known = known_[ray % kKnown];
    if (known.ray == ray && known.pieces.first <= piece && piece < known.pieces.end) return known.crossing;
    known = {ray, owners_.pieces_beside(piece), {}};
    finder_.find_of_one(rays_[ray], known.pieces, found_);
    for (const Hit& hit : found_)
      if (precedes(hit.t, hit.prim, known.crossing.t, known.crossing.prim)) known.crossing = hit;
    return known.crossing;
  }

 private:
  /// The crossing that was found last for some ray.
  struct Known {
    std::int64_t ray = -1;
    PieceRange pieces = {};
    Hit crossing;
  };
  static constexpr std::uint32_t kKnown = 2 * kGroupSize;

  const RayBatch& rays_;
  PieceOwners owners_;
  CrossingFinder<P> finder_;
  std::vector<Hit> found_;
  Known known_[kKnown];
};

}  // namespace fastlines
