// The library's sums over hits: those of its own lists of hits, the same bits on every instruction set and for rays
// with a spread; lines that are left out, and input that is refused.
#include <cmath>

#include "library.hpp"

using namespace fastlines;

namespace {

/// What the hits of a ray add up to, in double; NaN if one is on a line that is nearly parallel to the ray.
double expected_sum(const fl::Tree& tree, const fl::Ray& ray, const fl::Hits& hits, float radius) {
  double sum = 0.0;
  const double length = std::hypot(ray.direction.x, ray.direction.y, ray.direction.z);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto [t, prim, u, distance, t_out] = hits[i];
    const fl::RoundCone line = tree.line(prim);
    const double x = double(line.q.x) - line.p.x, y = double(line.q.y) - line.p.y, z = double(line.q.z) - line.p.z;
    const double cosine =
        (x * ray.direction.x + y * ray.direction.y + z * ray.direction.z) / (length * std::hypot(x, y, z));
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const double reach = line.radius_p + u * (double(line.radius_q) - line.radius_p) + radius;
    if (sine < 0.01) return std::nan("");
    if (u > 0 && u < 1 && t > ray.t_min && t < ray.t_max)
      sum += double(prim + 1) / (2 * reach * sine) * std::exp(-0.5 * t * length);
  }
  return sum;
}

void check_sums(const fl::Tree& tree, const Rays& rays, float radius) {
  std::vector<float> values;
  for (std::size_t i = 0; i < tree.size(); ++i) values.push_back(float(i + 1));
  fl::GatherOptions what;
  what.values = values;
  what.sigma[0] = 0.5f;
  what.squares = true;
  const fl::Gathered found = tree.gather(rays.all(), radius, what);
  const fl::HitLists lists = tree.all_hits(rays.all(), radius);
  check(found.sum.size() == rays.size() && found.squares.size() == rays.size(), "a sum for each ray");
  std::size_t n_compared = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double expected = expected_sum(tree, rays.one(i), lists[i], radius);
    check(!(std::fabs(found.sum[i] - expected) > 1e-4 * expected + 1e-9), "the sum of a ray");
    n_compared += expected > 0;
  }
  check(n_compared > 10, "some rays have hits");
  // The search of rays that leave lines out, one ray at a time, gives the same bits.
  fl::Rays special = rays.all();
  const std::int64_t none[] = {-1};
  special.ignore = none;
  const fl::Gathered again = tree.gather(special, radius, what);
  check(again.sum == found.sum && again.squares == found.squares && again.count == found.count, "one ray at a time");
  for (const char* simd : {"avx2", "sse42", "portable"}) {
    if (!message_of<fl::InputError>([&] { fl::set_simd(simd); }).empty()) continue;
    std::vector<fl::RoundCone> cones;
    for (std::size_t i = 0; i < tree.size(); ++i) cones.push_back(tree.line(std::int64_t(i)));
    const fl::Tree other = fl::build(cones, {.method = fl::Method::kd_cl});
    check(other.gather(rays.all(), radius, what).sum == found.sum, "instruction sets agree");
  }
  fl::set_simd(nullptr);
}

void check_input(const fl::Tree& tree, const Rays& rays) {
  const auto refuses = [&](const fl::GatherOptions& what, const char* why, float radius = 0.1f, fl::At at = {}) {
    fl::QueryOptions options;
    options.at = at;
    const std::string said = message_of<fl::InputError>([&] { tree.gather(rays.all(), radius, what, options); });
    if (said.find(why) == std::string::npos) std::printf("%s: %s\n", why, said.c_str());
    return said.find(why) != std::string::npos;
  };
  const std::vector<float> few(3, 1.0f), nan(tree.size(), std::nanf(""));
  fl::GatherOptions what;
  check(refuses(what, "leave out at", 0.1f, fl::At::surface), "the surface");
  check(refuses(what, "leaves a blur no width", 0.0f), "no radius");
  what.values = few;
  check(refuses(what, "values are 3 numbers"), "too few values");
  what.values = nan;
  check(refuses(what, "values[0] is NaN"), "NaN");
  what = {};
  what.n_channels = 9;
  check(refuses(what, "n_channels is 9"), "too many channels");
  what = {};
  what.sigma[3] = -1;
  check(refuses(what, "sigma[3]"), "a negative extinction");
  what = {};
  what.phase = 1.0f;
  check(refuses(what, "between -1 and 1"), "a phase function without a spread");
  what = {};
  what.optical_depth = few;
  what.n_depths = 1;
  check(refuses(what, "expected 2 steps or more"), "too few depths");
  what.n_depths = 2;
  check(refuses(what, "optical_depth"), "depths that do not match");
  what.n_depths = 0;
  check(refuses(what, "optical_depth has 3 numbers, and n_depths is 0; set both, or neither"), "depths without steps");
  what = {};
  what.n_depths = 5;
  check(refuses(what, "optical_depth has 0 numbers, and n_depths is 5"), "steps without depths");
}

void check_gather() {
  const test::Lines lines = test::hair(30);
  const std::vector<fl::Segment> segments = segments_of(lines);
  const Rays rays(test::scattered(lines, bounds_of_all(Segments{lines}), 1.0f));
  const fl::Tree thin = fl::build(segments), thick = fl::build(cones_of(segments, 0.5f));
  check_sums(thin, rays, 0.02f);
  check_sums(thick, rays, 0.02f);
  check_input(thin, rays);
  fl::Rays spread = rays.all();
  spread.spread = 0.01f;
  check(thin.gather(spread, 0.01f, {.squares = false}).count != thin.gather(rays.all(), 0.01f).count, "a spread");
  check(fl::Tree().gather(rays.all(), 0.1f).sum == std::vector<double>(rays.size()), "an empty tree has no hits");
}

}  // namespace

int main() { return test::run(check_gather); }
