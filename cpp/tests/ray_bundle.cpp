// Bundles of coherent rays: every ray stays within the culling radius of the axis wherever it is inside the scene's
// box, and BundleLineTest keeps every segment that the exact test hits.
#include <cmath>

#include "check.hpp"
#include "fastlines/kernels/traverse/bundle_line_test.hpp"
#include "fastlines/primitives/segment_test.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// The rays of a bundle: parallel, from or to a point, or nearly parallel.
enum Kind { parallel, from_a_point, to_a_point, twisted };

struct Rays {
  std::vector<Vec3> origins, directions;
  float radius, t_min, t_max;

  Rays(Random& random, Kind kind, int n, const Vec3& target) : t_min(0.0f), t_max(random.below(2) ? 100.0f : 2.5f) {
    Vec3 along = random.direction();
    while (dot(along, along) < 0.01f) along = random.direction();
    along = along * (1.0f / std::sqrt(dot(along, along)));
    const float width = std::pow(10.0f, random.uniform(-3.0f, -0.7f));
    radius = random.below(4) == 0 ? 0.0f : std::pow(10.0f, random.uniform(-5.0f, -1.0f));
    const Vec3 from = target - along * random.uniform(0.5f, 4.0f);
    for (int i = 0; i < n; ++i) {
      const Vec3 at = target + random.direction() * width;
      Vec3 start = from + random.direction() * width;
      if (kind == parallel) start = at - along * 2.0f;
      if (kind == from_a_point) start = from;
      const Vec3 to = kind == to_a_point ? target : at;
      origins.push_back(start);
      directions.push_back((to - start) * random.uniform(0.5f, 2.0f));
    }
  }
  RayBatch batch() const { return {origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}}; }
};

/// The distance of a point of a ray from the axis, in double precision.
double off_axis(const RayBundle& bundle, const Vec3& axis_from, const double (&point)[3]) {
  double along = 0.0, off2 = 0.0;
  for (int k = 0; k < 3; ++k) along += (point[k] - axis_from[k]) * bundle.c[k];
  for (int k = 0; k < 3; ++k) {
    const double off = point[k] - axis_from[k] - along * bundle.c[k];
    off2 += off * off;
  }
  return std::sqrt(off2);
}

void check_cull_radius(const RayBundle& bundle, const RayGroup& rays, const Box& scene, int n) {
  Vec3 mean{0, 0, 0};  // a point of the axis; `bundle.centre` may have been moved along it
  for (int i = 0; i < round_up_to_width(n); ++i)
    for (int k = 0; k < 3; ++k) mean[k] += rays.o[k][i] / float(round_up_to_width(n));
  for (int i = 0; i < n; ++i)
    for (int step = -64; step <= 64; ++step) {
      double at[3];
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        at[k] = rays.o[k][i] + step * 0.05 * rays.r[k][i];
        inside &= scene.lo[k] <= at[k] && at[k] <= scene.hi[k];
      }
      if (inside)
        check(off_axis(bundle, mean, at) + rays.cull_radius[i] <= bundle.offset,
              "a ray stays within the culling radius");
    }
}

int check_lines(RayBundle& bundle, const RayGroup& rays, const WideBvhView<Segments>& tree, std::size_t n_segments,
                int n) {
  float limit[kGroupSize];
  std::copy_n(rays.t_max, kGroupSize, limit);
  bundle.update_depths(limit);
  int n_hits = 0;
  const auto lines = std::make_unique<BundleLineTest<Segments>>();
  for (std::size_t begin = 0; begin + kSimdWidth <= n_segments; begin += kSimdWidth) {
    std::uint32_t prims[kSimdWidth];
    for (int j = 0; j < kSimdWidth; ++j) prims[j] = std::uint32_t(begin) + std::uint32_t(j);
    lines->load(tree, prims, bundle);
    lines->test(bundle, kSimdWidth, [&](int j, int first, std::uint32_t near) {
      for (int i = first; i < std::min(first + kSimdWidth, n); ++i) {
        const LaneView ray(rays, i);
        const auto fields = fields_of<Segments>(tree.items[prims[j]], tree.frame);
        if (!Segments::test<float>(ray, fields).closest.hit) continue;
        ++n_hits;
        check(near >> (i - first) & 1, "a segment that a ray hits is kept");
      }
    });
  }
  return n_hits;
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    const Box scene{{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}};
    const Frame frame = frame_of(scene);  // scale 1, centre 0
    const auto rays = std::make_unique<RayGroup>();
    const auto bundle = std::make_unique<RayBundle>();
    int n_bundles[4] = {}, n_hits[4] = {}, n_from_apex = 0;
    for (int round = 0; round < 1200; ++round) {
      const auto kind = Kind(round % 4);
      const int n = round % 3 == 0 ? kGroupSize : 1 + int(random.below(kGroupSize));
      std::vector<Segment> segments;
      const Vec3 target = random.direction() * 0.8f;
      for (int i = 0; i < 4 * kSimdWidth; ++i) {
        const Vec3 p = i % 2 ? random.direction() : target + random.direction() * 0.05f;
        segments.push_back({p, i % 8 == 7 ? p : p + random.direction() * (i % 4 == 0 ? 1.0f : 0.02f)});
      }
      const Rays from(random, kind, n, target);
      std::uint32_t ids[kGroupSize];
      for (int i = 0; i < n; ++i) ids[i] = std::uint32_t(i);
      rays->fill(from.batch(), frame, n, ids);
      if (!bundle->try_fit(*rays, 0, round_up_to_width(n), scene)) continue;
      ++n_bundles[kind];
      n_from_apex += bundle->from_apex;
      check_cull_radius(*bundle, *rays, scene, n);
      const WideBvhView<Segments> tree{frame, scene, 1.0f, nullptr, nullptr, nullptr, segments.data()};
      n_hits[kind] += check_lines(*bundle, *rays, tree, segments.size(), n);
    }
    for (const Kind kind : {parallel, from_a_point, to_a_point, twisted})
      check(n_bundles[kind] > 100 && n_hits[kind] > 1000, "bundles of each kind are tested, and rays hit segments");
    check(n_from_apex > 100, "rays from a point are found");
  });
}
