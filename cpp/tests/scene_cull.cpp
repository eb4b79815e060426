// Culls rays with the box of a scene: no ray that hits is culled, however closely it passes, and rays that clearly miss
// the box are.
#include "fastlines/kernels/intersect/scene_cull.hpp"

#include <vector>

#include "check.hpp"
#include "fastlines/primitives/segments.hpp"
#include "fastlines/query/test_primitive.hpp"
#include "fastlines/rays/frame_of.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// Some segments and the box that rays are culled with.
struct Scene {
  std::vector<Segment> lines;
  Box box = Box::empty();
  WideBvhView<Segments> view{};

  /// Segments around a place; some are flat along an axis, or all of them are.
  Scene(Random& random, float size, float where) {
    for (int i = 0; i < 3; ++i) {
      Segment line{random.direction() * size, random.direction() * size};
      if (i != 1) line.p[int(random.below(3))] = line.q[int(random.below(3))] = 0.0f;
      if (where != 0.0f) line.p[2] = line.q[2] = where;
      lines.push_back(line);
    }
    for (const Segment& line : lines)
      for (const Vec3& end : {line.p, line.q}) box.grow(end);
    view.frame = frame_of(box);
    view.box = {view.frame(box.lo), view.frame(box.hi)};
  }
};

/// Whether a ray hits one of the segments.
bool hits(const Scene& scene, const RayQuery& ray) {
  const Segments prims{scene.lines};
  const Ray prepared = prepare(ray, scene.view.frame);
  for (std::uint32_t prim = 0; prim < prims.size(); ++prim)
    if (exact_test(prims, prepared, scene.view.frame, prim).closest.hit) return true;
  return false;
}

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A ray that passes a point of a segment at its radius, or nearly so. Its interval may end there.
RayQuery grazing_ray(const Scene& scene, float size, Random& random) {
  const Segment& line = scene.lines[random.below(scene.lines.size())];
  const float s = random.below(3) ? float(random.below(2)) : random.uniform();
  const Vec3 at = line.p + (line.q - line.p) * s;
  Vec3 d = random.direction();
  for (int k = 0; k < 3; ++k)
    if (random.below(3) == 0) d[k] = 0.0f;
  if (length_of(d) == 0.0) d = {0.0f, 0.0f, -1.0f};
  Vec3 away = cross(d, random.direction());
  if (length_of(away) > 0.0) away = away * float(1.0 / length_of(away));
  constexpr float kRadii[] = {0.0f, 1e-6f, 1e-3f, 0.3f};
  const float radius = kRadii[random.below(4)] * size;
  const float before = float(random.below(3)) * 5.0f * size;
  RayQuery ray{at + away * radius - d * before, d, -kInfinity, kInfinity, radius};
  if (random.below(2)) ray.t_max = before;
  if (random.below(2)) ray.t_min = before;
  return ray;
}

/// A ray that passes the box, grown by its radius, at a fiftieth of the scene's size: an endless one beside it, or one
/// that begins beyond a face and leads away.
RayQuery distant_ray(const Scene& scene, float size, Random& random) {
  const int i = int(random.below(3)), j = (i + 1) % 3;
  Vec3 d = random.direction(), out{0.0f, 0.0f, 0.0f};
  const float radius = random.uniform() * size;
  RayQuery ray{{}, d, -kInfinity, kInfinity, radius};
  if (random.below(2)) {
    out[i] = d[i] < 0.0f ? -1.0f : 1.0f;
    ray.t_min = 0.0f;
  } else {
    const float length = std::sqrt(d[i] * d[i] + d[j] * d[j]);
    out[i] = -d[j] / length;
    out[j] = d[i] / length;
  }
  float reach = 0.02f * size;  // of the box, grown by the radius on all sides
  for (int k = 0; k < 3; ++k) {
    ray.origin[k] = 0.5f * (scene.box.lo[k] + scene.box.hi[k]);
    reach += (0.5f * (scene.box.hi[k] - scene.box.lo[k]) + radius) * std::abs(out[k]);
  }
  ray.origin = ray.origin + out * reach;
  return ray;
}

void check_scenes() {
  Random random{64};
  int n_hits = 0, n_rays = 0;
  for (const float size : {1e-6f, 1.0f, 1e6f})
    for (const float where : {0.0f, 10.0f, 1e5f})
      for (int i = 0; i < 300; ++i) {
        const Scene scene(random, size, where * size);
        const SceneCull cull(scene.view);
        for (int j = 0; j < 20; ++j, ++n_rays) {
          const RayQuery ray = grazing_ray(scene, size, random);
          const bool is_hit = hits(scene, ray);
          n_hits += is_hit;
          check(!is_hit || !cull.surely_misses(ray), "a ray that hits is not culled");
          if (where < 100.0f)
            check(cull.surely_misses(distant_ray(scene, size, random)), "a ray that clearly misses is culled");
        }
      }
  check(n_hits > n_rays / 4, "many rays hit");
}

}  // namespace

int main() { return test::run(check_scenes); }
