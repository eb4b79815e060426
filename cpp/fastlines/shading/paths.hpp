// Path tracing: how light scatters at the vertices of all paths, in one bounce.
//
// Each path starts at a point that the camera sees. At each vertex it gathers the light that comes straight from the
// distant lights, and goes on in a direction that is drawn as light is scattered. If it leaves the scene, it gathers
// the light of the sky. So
//
//     L(x, ωo) = Σ_lights E S(ωo, ωl) V(x, ωl) + 𝔼[ weight · (L or the sky) ],
//
// where S is the scattering with its cosine, E an irradiance and V the visibility. After the first vertex, one light is
// chosen by what it would bring if nothing were in between. Paths end by chance, as their weight falls ("Russian
// roulette"), so the mean is that of paths without end, up to the greatest number of bounces.
//
// All paths go on side by side (a wavefront). What lies in between, and what rays hit next, are queries on the tree.
// Sources: Kajiya, "The Rendering Equation", 1986; Laine et al., "Megakernels Considered Harmful", 2013.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "../math/vec.hpp"
#include "../memory/large_vector.hpp"
#include "hair_points.hpp"
#include "lights.hpp"
#include "path_vertices.hpp"
#include "sobol.hpp"

namespace fastlines {

/// The number of bounces after which paths end by chance.
inline constexpr int kSureBounces = 3;

/// Light below this fraction of the irradiance of the brightest light is offered by chance, and then counts more.
inline constexpr float kFaint = 1.0f / 64.0f;

/// The lights and the materials of a scene: of fibres, and of surfaces without an axis, which reflect evenly.
struct PathScene {
  std::span<const DistantLight> lights;
  HairMaterial hair;
  float skin[3];
  float least_start;  ///< where rays start at least
};

/// Paths that have arrived at vertices: for each vertex the number of its path and the path's weight, and for each path
/// the seed of its random numbers.
struct PathRows {
  const std::int64_t* path;
  const float* weight;
  const std::uint32_t* seeds;
};

/// Which sample the paths are of, the dimension of its next random numbers, and how often light was scattered before.
struct PathStep {
  std::uint32_t index;
  int dimension, bounce;
};

/// Rays that leave some of the vertices, and what each brings along: light that is offered, or the weight of its path.
struct LeavingRays {
  LargeVector<std::int64_t> vertex;
  LargeVector<Vec3> points, directions, value;
  LargeVector<float> start;

  void reserve(std::size_t n) {
    vertex.reserve(n);
    points.reserve(n);
    directions.reserve(n);
    value.reserve(n);
    start.reserve(n);
  }

  /// Append the rays in the lanes of a mask, of which lane 0 is of vertex `first`.
  void append(const IntLanes& mask, std::int64_t first, int count, const PathVertices& from, const Vec3Lanes& towards,
              const Vec3Lanes& brought, float least_start) {
    float at[3 * kLanes], way[3 * kLanes], bring[3 * kLanes], starts[kLanes];
    std::int32_t leaves[kLanes];
    store_lanes(mask, leaves, kLanes);
    from.points.store(at, count);
    towards.store(way, count);
    brought.store(bring, count);
    store_lanes(from.exits(towards, least_start), starts, kLanes);
    for (int i = 0; i < count; ++i) {
      if (!leaves[i]) continue;
      const auto row = [i](const float* all) { return Vec3{all[3 * i], all[3 * i + 1], all[3 * i + 2]}; };
      vertex.push_back(first + i);
      points.push_back(row(at));
      directions.push_back(row(way));
      value.push_back(row(bring));
      start.push_back(starts[i]);
    }
  }
};

/// The scattering at 16 vertices.
class PathScattering {
 public:
  PathScattering(const PathScene& scene, const PathVertices& vertices)
      : scene_(scene),
        vertices_(vertices),
        bare_(vertices.bare()),
        any_bare_(any(bare_)),
        hair_(scene.hair, vertices.to_eye, vertices.tangents, vertices.h()) {}

  /// How much of the light from some directions goes to the eye, per steradian, cosine included.
  Vec3Lanes evaluate(const Vec3Lanes& towards) const {
    const Vec3Lanes value = hair_.evaluate(towards);
    if (!any_bare_) return value;
    const FloatLanes facing = max(dot(vertices_.normals, towards), FloatLanes(0.0f));
    return select(bare_, facing * (1.0f / kPi) * Vec3Lanes::of(scene_.skin), value);
  }

  struct Sampled {
    Vec3Lanes towards, weight;
  };
  /// Draw directions, and weigh each: `evaluate` by its density.
  Sampled sample(const FloatLanes (&u)[4]) const {
    const auto [towards, weight, _] = hair_.sample(u);
    if (!any_bare_) return {towards, weight};
    return {select(bare_, hemisphere(vertices_.normals, u[0], u[1]), towards),
            select(bare_, Vec3Lanes::of(scene_.skin), weight)};
  }

 private:
  const PathScene& scene_;
  const PathVertices& vertices_;
  IntLanes bare_;
  bool any_bare_;
  HairPoints hair_;
};

/// Scatters light at the vertices of one bounce.
class PathBounce {
 public:
  /// Rays to lights, which bring what they offer unless something hides them: of each light at first, and then of one
  /// chosen for each vertex.
  std::vector<LeavingRays> shadows;
  /// Rays that go on.
  LeavingRays onward;
  /// The dimension of the next random numbers.
  int dimension;

  PathBounce(const PathScene& scene, const PathStep& step, const PathVertexRows& vertices, const PathRows& paths)
      : shadows(chooses(scene, step) ? 1 : scene.lights.size()), dimension(step.dimension) {
    for (const DistantLight& light : scene.lights)
      for (const float each : light.color) faint_ = std::max(faint_, kFaint * each);
    for (LeavingRays& rays : shadows) rays.reserve(vertices.n);
    onward.reserve(vertices.n);
    std::vector<Offer> offers(scene.lights.size());
    for (std::size_t i = 0; i < vertices.n; i += kLanes) {
      const int count = int(std::min<std::size_t>(kLanes, vertices.n - i));
      WordLanes seeds;
      for (int lane = 0; lane < kLanes; ++lane) seeds.set(lane, paths.seeds[paths.path[i + std::min(lane, count - 1)]]);
      PathNumbers numbers(step.index, seeds, step.dimension);
      const Group group{std::int64_t(i), count, PathVertices::load(vertices, i, count),
                        Vec3Lanes::load(paths.weight + 3 * i, count)};
      const PathScattering scattering(scene, group.vertices);
      gather(scene, step, group, scattering, numbers, offers);
      go_on(scene, step, group, scattering, numbers);
      dimension = numbers.dimension();
    }
  }

 private:
  struct Group {
    std::int64_t first;
    int count;
    PathVertices vertices;
    Vec3Lanes weight;
  };
  /// The directions to a light, what comes from there unless it is hidden, and the sum of that of all lights so far.
  struct Offer {
    Vec3Lanes towards, light;
    FloatLanes sum;
  };

  static FloatLanes sum(const Vec3Lanes& light) { return light.x + light.y + light.z; }
  static FloatLanes brightest(const Vec3Lanes& light) { return max(max(light.x, light.y), light.z); }

  static bool chooses(const PathScene& scene, const PathStep& step) {
    return step.bounce > 0 && scene.lights.size() > 1;
  }

  void gather(const PathScene& scene, const PathStep& step, const Group& group, const PathScattering& scattering,
              PathNumbers& numbers, std::vector<Offer>& offers) {
    FloatLanes all = 0.0f;
    for (std::size_t k = 0; k < offers.size(); ++k) {
      FloatLanes u[2];
      numbers.take(u);
      const Vec3Lanes towards = scene.lights[k].sample(u[0], u[1]);
      const Vec3Lanes light = Vec3Lanes::of(scene.lights[k].color) * scattering.evaluate(towards);
      all += sum(light);
      offers[k] = {towards, light, all};
    }
    FloatLanes u[2];  // for the choice of a light, and for faint light
    numbers.take(u);
    if (!chooses(scene, step)) {
      for (std::size_t k = 0; k < offers.size(); ++k)
        offer(scene, group, offers[k].towards, group.weight * offers[k].light, u[1], shadows[k]);
      return;
    }
    // Choose a light, and count it more the less likely it is.
    const FloatLanes aim = u[0] * all;
    Offer chosen = offers[0];
    for (std::size_t k = 1; k < offers.size(); ++k) {
      const IntLanes later = aim >= offers[k - 1].sum;
      chosen.towards = select(later, offers[k].towards, chosen.towards);
      chosen.light = select(later, offers[k].light, chosen.light);
    }
    const FloatLanes more = all / max(sum(chosen.light), FloatLanes(1e-30f));
    offer(scene, group, chosen.towards, group.weight * (more * chosen.light), u[1], shadows[0]);
  }

  /// Add rays to a light; of those that bring little, some, which count more.
  void offer(const PathScene& scene, const Group& group, const Vec3Lanes& towards, const Vec3Lanes& light,
             const FloatLanes& chance, LeavingRays& rays) const {
    const FloatLanes likely = min(brightest(light) * (1.0f / faint_), FloatLanes(1.0f));
    rays.append(chance < likely, group.first, group.count, group.vertices, towards,
                1.0f / max(likely, FloatLanes(1e-30f)) * light, scene.least_start);
  }

  void go_on(const PathScene& scene, const PathStep& step, const Group& group, const PathScattering& scattering,
             PathNumbers& numbers) {
    FloatLanes u[4], chance[1];
    numbers.take(u);
    numbers.take(chance);
    const auto [towards, change] = scattering.sample(u);
    const Vec3Lanes weight = group.weight * change;
    const FloatLanes lasts = step.bounce < kSureBounces ? FloatLanes(1.0f) : min(brightest(weight), FloatLanes(1.0f));
    onward.append(chance[0] < lasts, group.first, group.count, group.vertices, towards, 1.0f / lasts * weight,
                  scene.least_start);
  }

  float faint_ = 1e-30f;  ///< light below it is offered by chance
};

}  // namespace fastlines
