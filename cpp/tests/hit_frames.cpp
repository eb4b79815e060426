// Frames of hits, eight at a time, have the bits of those of one hit in scalar code.
#include "fastlines/query/hit_frames.hpp"

#include <bit>
#include <vector>

#include "check.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

using Vector = Vector3<double>;

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (a != a && b != b);
}
bool same(const std::array<double, 3>& a, const Vector& b) {
  return same(a[0], b.x) && same(a[1], b.y) && same(a[2], b.z);
}

/// Segments with radii, some of length zero and some with a tip, and rays that hit them, start inside or miss.
struct Scene {
  std::vector<std::array<float, 8>> rows;
  std::vector<std::int64_t> prim, ray;
  std::vector<double> u, t;
  std::vector<Vec3> origins, directions;
  std::vector<float> radius, t_min, t_max;

  Scene(Random& random, std::size_t n_hits) {
    const auto number = [&] { return random.uniform(-1.0f, 1.0f); };
    for (int i = 0; i < 20; ++i) {
      auto& row = rows.emplace_back();
      for (int k = 0; k < 6; ++k) row[k] = i % 5 == 0 && k >= 3 ? row[k - 3] : number();
      row[6] = random.below(4) ? random.uniform(0.0f, 2.0f) : 0.0f;
      row[7] = random.below(4) ? row[6] : random.uniform(0.0f, 2.0f);
    }
    for (std::size_t i = 0; i < n_hits; ++i) {
      prim.push_back(random.below(9) ? std::int64_t(random.below(rows.size())) : -1);
      ray.push_back(std::int64_t(n_hits - 1 - i));
      u.push_back(random.uniform(0.0f, 1.0f));
      origins.push_back({number(), number(), random.below(3) ? -4.0f : number()});
      directions.push_back({0.3f * number(), 0.3f * number(), random.uniform(0.5f, 2.0f)});
      radius.push_back(random.uniform(0.0f, 0.5f));
      t_min.push_back(0.0f);
      t_max.push_back(random.below(5) ? kInfinity : 2.0f);
    }
    for (std::size_t i = 0; i < n_hits; ++i)
      t.push_back(random.below(3) ? random.uniform(0.0f, 4.0f) : random.below(2) ? 0.0 : t_max[std::size_t(ray[i])]);
  }
};

void check_lines(Random& random, std::size_t n_hits) {
  const Scene scene(random, n_hits);
  const RayBatch rays{scene.origins, scene.directions, scene.radius, scene.t_min, scene.t_max};
  const std::span<const float> numbers{scene.rows[0].data(), 8 * scene.rows.size()};
  const HitPlaces places{scene.prim, scene.u, scene.t, scene.ray, true};
  check(places.are_of(scene.rows.size(), n_hits) && !places.are_of(scene.rows.size(), n_hits - 1),
        "hits name what there is");
  std::vector<std::array<double, 3>> points(n_hits), normals(n_hits), tangents(n_hits);
  std::vector<double> radius(n_hits);
  Progress progress;
  FrameColumns<double> to;
  to.points = points.data();
  to.normals = normals.data();
  to.tangents = tangents.data();
  to.radius = radius.data();
  store_frames(HitSource({numbers}, &rays), places, to, 2, progress);

  const auto vector = [](const float* v) { return Vector{v[0], v[1], v[2]}; };
  for (std::size_t i = 0; i < n_hits; ++i) {
    if (scene.prim[i] < 0) {
      check(points[i][0] != points[i][0] && normals[i][1] != normals[i][1], "a miss has no point and no normal");
      check(tangents[i][2] != tangents[i][2] && radius[i] != radius[i], "a miss has no tangent and no radius");
      continue;
    }
    const auto& row = scene.rows[std::size_t(scene.prim[i])];
    const auto of = std::size_t(scene.ray[i]);
    const Vector start = vector(row.data()), edge = vector(row.data() + 3) - start;
    const Vector origin = vector(scene.origins[of].data()), direction = vector(scene.directions[of].data());
    const double grown[2] = {double(row[6]) + scene.radius[of], double(row[7]) + scene.radius[of]};
    double t = scene.t[i], s = scene.u[i];
    const auto entry = enter(RoundConeInDouble<double>{start, edge, grown[0], grown[1] - grown[0]}, origin, direction);
    if (t != scene.t_min[of] && t != scene.t_max[of] && std::isfinite(entry.t)) t = entry.t, s = entry.s;
    const Vector point = origin + t * direction, away = point - (start + s * edge);
    check(same(points[i], point), "points");
    check(same(normals[i], unit(is_zero(away) ? -direction : away)), "normals");
    check(same(tangents[i], unit(edge)), "tangents");
    const double own = (1.0 - scene.u[i]) * row[6] + scene.u[i] * row[7];
    check(same(radius[i], own + scene.radius[of]), "radii");
  }
}

/// Without any axis, all are misses, and there is no memory to read.
void check_no_axes(const Axes& axes, std::size_t n) {
  const std::vector<std::int64_t> prim(n, -1);
  const std::vector<double> u(n), t(n);
  const std::vector<Vec3> vectors(n);
  const float radius = 0.0f, t_min = 0.0f, t_max = kInfinity;
  const RayBatch rays{vectors, vectors, {&radius, 1}, {&t_min, 1}, {&t_max, 1}};
  std::vector<std::array<double, 3>> points(n);
  Progress progress;
  FrameColumns<double> to;
  to.points = points.data();
  store_frames(HitSource(axes, &rays), {prim, u, t, {}, true}, to, 1, progress);
  for (const auto& point : points) check(point[0] != point[0] && point[2] != point[2], "a miss has no point");
}

}  // namespace

int main() {
  return test::run([] {
    const CubicCurves no_curves;
    for (const std::size_t n : {1, 3, 8, 13}) check_no_axes({}, n), check_no_axes({{}, 8, &no_curves}, n);
    Random random{1};
    for (const std::size_t n : {1, 7, 8, 9, 63, 5000})
      for (int round = 0; round < 10; ++round) check_lines(random, n);
  });
}
