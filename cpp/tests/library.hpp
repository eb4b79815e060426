// What the tests of the library share: lines, rays, and all hits by brute force.
#pragma once

#include "check.hpp"
#include "fastlines/fastlines.hpp"
#include "scenes.hpp"

using fastlines::test::check;

inline std::vector<fl::Segment> segments_of(const std::vector<fastlines::Segment>& lines) {
  std::vector<fl::Segment> segments;
  for (const auto& [p, q] : lines) segments.push_back({{p[0], p[1], p[2]}, {q[0], q[1], q[2]}});
  return segments;
}

/// The same lines with radii that differ from end to end.
inline std::vector<fl::RoundCone> cones_of(const std::vector<fl::Segment>& segments, float size) {
  std::vector<fl::RoundCone> cones;
  for (std::size_t i = 0; i < segments.size(); ++i)
    cones.push_back({segments[i].p, segments[i].q, size * 0.01f * float(i % 3), size * 0.01f * float(i % 5)});
  return cones;
}

struct Rays {
  std::vector<fl::Vec3> origins, directions;
  std::vector<float> radius, t_min, t_max;

  Rays(const fastlines::test::Rays& from) {
    const auto batch = from.batch();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const fastlines::RayQuery ray = batch[i];
      origins.push_back({ray.origin[0], ray.origin[1], ray.origin[2]});
      directions.push_back({ray.direction[0], ray.direction[1], ray.direction[2]});
      radius.push_back(ray.radius);
      t_min.push_back(ray.t_min);
      t_max.push_back(ray.t_max);
    }
  }
  std::size_t size() const { return origins.size(); }
  fl::Ray one(std::size_t i) const { return {origins[i], directions[i], t_min[i], t_max[i]}; }
  fl::Rays all() const { return {origins, directions, std::span<const float>(t_min), std::span<const float>(t_max)}; }
};

inline bool same(const fl::Hit& a, const fl::Hit& b) {
  return a.t == b.t && a.prim == b.prim && a.u == b.u && a.distance == b.distance && a.t_out == b.t_out;
}
template <class A, class B>
bool same_lists(const A& a, const B& b) {
  bool equal = a.size() == b.size();
  for (std::size_t i = 0; equal && i < a.size(); ++i) equal = same(a[i], b[i]);
  return equal;
}

/// All hits of each ray by brute force.
template <class P>
std::vector<std::vector<fl::Hit>> expected_hits(const P& prims, const Rays& rays, fl::At at) {
  const auto core_at = fastlines::At(int(at));
  fastlines::Box box = fastlines::bounds_of_all(prims);
  const fastlines::BruteForce<P> brute{prims, fastlines::frame_of(box, fastlines::max_radius_of(prims))};
  std::vector<std::vector<fl::Hit>> found;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto &o = rays.origins[i], &d = rays.directions[i];
    const fastlines::Ray ray = fastlines::prepare(
        {{o.x, o.y, o.z}, {d.x, d.y, d.z}, rays.t_min[i], rays.t_max[i], rays.radius[i]}, brute.frame);
    found.emplace_back();
    fastlines::HitVectorOfRay<fl::Hit> list(ray, core_at, fastlines::Keep::all, found.back());
    typename fastlines::BruteForce<P>::Scratch scratch;
    brute(ray, list, scratch);
    list.finish();
    if (at != fl::At::closest)
      for (fl::Hit& hit : found.back()) hit.t_out = fastlines::exit_of(brute, ray, hit.prim);
  }
  return found;
}

/// What a call throws, or an empty text.
template <class Error, class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}
