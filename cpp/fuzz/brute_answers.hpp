// The answers of brute force for one ray or one point.
#pragma once

#include <vector>

#include "fastlines/core.hpp"

namespace fastlines::fuzz {

template <RayPrimitive P>
class BruteAnswers {
 public:
  /// Queries compute in the frame of a box.
  BruteAnswers(const P& prims, const Box& frame_box)
      : prims_(prims), rays_{prims, frame_of(frame_box, max_radius_of(prims))}, point_frame_(frame_of(frame_box)) {}

  /// All hits of a ray, in their order.
  template <class AnyHit>
  void all_hits(const RayQuery& query, At at, std::vector<AnyHit>& to) const {
    const auto ray = prepare(query, rays_.frame);
    HitVectorOfRay<AnyHit> list(ray, at, Keep::all, to);
    typename BruteForce<P>::Scratch scratch;
    rays_(ray, list, scratch);
    list.finish();
    if (has_exit(at))
      for (AnyHit& hit : to) hit.t_out = exit_of(rays_, ray, hit.prim);
  }

  /// What is within a radius of a point, the nearest first; distances are in the frame.
  void within(const double* point, float radius, bool surface, std::vector<Neighbour>& to) const {
    const PointQuery query = prepare_point(point, radius, surface, point_frame_);
    const Seen all;
    to.clear();
    WithinOfPoint list(query, 0, all, false, to);
    Progress progress;
    Checkpoint checkpoint(progress);
    typename BruteForcePoints<P>::Scratch scratch;
    BruteForcePoints<P>{prims_, point_frame_}(query, list, scratch, checkpoint);
    list.finish();
  }

  const Frame& frame() const { return point_frame_; }

 private:
  const P& prims_;
  BruteForce<P> rays_;
  Frame point_frame_;
};

}  // namespace fastlines::fuzz
