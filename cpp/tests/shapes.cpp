// Compares the exact tests of triangles and boxes with their definitions in float64, and checks that closed meshes are
// watertight, and that the box of a part of a round cone holds it.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "check.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/rays/frame_of.hpp"
#include "fastlines/rays/ray.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

using Point = std::array<double, 3>;

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Point& a) { return std::sqrt(dot(a, a)); }
Point point(const Vec3& a) { return {a[0], a[1], a[2]}; }
Point at(const RayQuery& ray, double t) {
  Point x = point(ray.origin);
  for (int k = 0; k < 3; ++k) x[k] += t * ray.direction[k];
  return x;
}

/// The distance of a point from a segment.
double distance_from(const Point& x, const Point& p, const Point& q) {
  const Point e = minus(q, p), a = minus(x, p);
  const double length2 = dot(e, e), s = length2 > 0 ? std::clamp(dot(a, e) / length2, 0.0, 1.0) : 0.0;
  return norm({a[0] - s * e[0], a[1] - s * e[1], a[2] - s * e[2]});
}

/// The distance of a point from a triangle.
double distance_from(const Point& x, const Triangle& triangle) {
  const Point a = point(triangle.corner[0]), b = point(triangle.corner[1]), c = point(triangle.corner[2]);
  double least = std::min({distance_from(x, a, b), distance_from(x, b, c), distance_from(x, c, a)});
  const Point n = cross(minus(b, a), minus(c, a));
  if (const double length = norm(n); length > 0) {
    const bool inside = dot(cross(minus(b, a), minus(x, a)), n) >= 0 && dot(cross(minus(c, b), minus(x, b)), n) >= 0 &&
                        dot(cross(minus(a, c), minus(x, c)), n) >= 0;
    if (inside) least = std::min(least, std::abs(dot(minus(x, a), n)) / length);
  }
  return least;
}

/// How near a ray's line comes to the edges of a triangle: the distance of lines, or of an end of an edge.
double distance_of_edges(const RayQuery& ray, const Triangle& triangle) {
  double least = HUGE_VAL;
  const Point d = point(ray.direction), o = point(ray.origin);
  for (int i = 0; i < 3; ++i) {
    const Point p = point(triangle.corner[i]), q = point(triangle.corner[(i + 1) % 3]);
    const Point e = minus(q, p), w = minus(p, o), n = cross(d, e);
    for (const Point& end : {p, q}) least = std::min(least, norm(cross(minus(end, o), d)) / norm(d));
    if (norm(n) == 0) continue;
    // The s at which the line of the edge is nearest to the ray.
    const double s = dot(cross(w, d), n) / dot(n, n);
    if (s >= 0 && s <= 1) least = std::min(least, std::abs(dot(w, n)) / norm(n));
  }
  return least;
}

/// The largest deviations, as a fraction of the size of the scene.
struct Worst {
  double decision = 0, place = 0;
  std::size_t n_hits = 0;
};

ClosestApproach<float> test_shape(const Shape& shape, const Ray& ray, const Frame& frame) {
  const auto test = Shapes::test<float>(ray, fields_of<Shapes>(shape, frame));
  check(!test.closest.hit || test.entry().t == test.closest.t, "t does not depend on where it is taken");
  return test.closest;
}

/// Check a triangle: whether it is hit, and that the hit lies on it.
void check_triangle(const RayQuery& query, const Triangle& triangle, const Frame& frame, double size, Worst& worst) {
  const Ray ray = prepare(query, frame);
  const auto found = test_shape(shape_of(Shape::triangle, triangle), ray, frame);
  const Point a = point(triangle.corner[0]), b = point(triangle.corner[1]), c = point(triangle.corner[2]);
  const Point n = cross(minus(b, a), minus(c, a)), o = point(query.origin), d = point(query.direction);
  const double facing = dot(n, d), t = dot(n, minus(a, o)) / facing;
  const Point x = at(query, t);
  const bool inside = facing != 0 && dot(cross(minus(b, a), minus(x, a)), n) >= 0 &&
                      dot(cross(minus(c, b), minus(x, b)), n) >= 0 && dot(cross(minus(a, c), minus(x, c)), n) >= 0;
  const bool is_hit = inside && t >= query.t_min && t <= query.t_max;
  if (found.hit != is_hit) {
    // The decision is wrong only where the line passes near an edge, or where a bound cuts it off at the triangle.
    double off = distance_of_edges(query, triangle);
    for (const double bound : {double(query.t_min), double(query.t_max)})
      if (std::isfinite(bound)) off = std::min(off, distance_from(at(query, bound), triangle));
    worst.decision = std::max(worst.decision, off / size);
  }
  if (!found.hit) return;
  ++worst.n_hits;
  worst.place = std::max(worst.place, distance_from(at(query, ray.t_ray(found.t)), triangle) / size);
}

/// Check a box: its entry and exit by slabs.
void check_box(const RayQuery& query, const Box& box, const Frame& frame, double size, Worst& worst) {
  const Ray ray = prepare(query, frame);
  const Shape shape = shape_of(Shape::box, box);
  const auto found = test_shape(shape, ray, frame);
  // Whether it hits the box grown on all sides.
  const auto is_hit = [&](double grow) {
    double t0 = query.t_min, t1 = query.t_max;
    for (int k = 0; k < 3; ++k) {
      const double lo = box.lo[k] - grow - query.origin[k], hi = box.hi[k] + grow - query.origin[k];
      const double r = query.direction[k];
      if (lo > hi) return false;
      if (r == 0) {
        if (lo > 0 || hi < 0) return false;
        continue;
      }
      t0 = std::max(t0, std::min(lo / r, hi / r));
      t1 = std::min(t1, std::max(lo / r, hi / r));
    }
    return t0 <= t1;
  };
  if (found.hit != is_hit(0.0)) {
    double low = 0, high = size;
    for (int i = 0; i < 60; ++i) {
      const double grow = 0.5 * (low + high);
      (is_hit(found.hit ? grow : -grow) == found.hit ? high : low) = grow;
    }
    worst.decision = std::max(worst.decision, high / size);
  }
  if (!found.hit) return;
  ++worst.n_hits;
  const Point x = at(query, ray.t_ray(found.t));
  double off = 0;
  for (int k = 0; k < 3; ++k) off = std::max({off, box.lo[k] - x[k], x[k] - box.hi[k]});
  worst.place = std::max(worst.place, off / size);
}

/// Where a scene of size 2 lies: coordinates are multiplied by `scale`, and then moved by `offset` along each axis.
struct Placement {
  float scale, offset;
  Vec3 operator()(const Vec3& x) const { return x * scale + Vec3{offset, offset, offset}; }
};

/// What is special about a case.
enum Kind { general, small, needle, edge_on, at_edge, at_corner, n_kinds };
constexpr const char* kNames[] = {"general", "small", "needle", "edge on", "at an edge", "at a corner"};

void check_random(Random& random, Kind kind, const Placement& place, const Frame& frame, double size, Worst& triangles,
                  Worst& boxes) {
  Vec3 a = random.in_cube() * 2.0f - Vec3{1, 1, 1}, b = random.in_cube() * 2.0f - Vec3{1, 1, 1},
       c = random.in_cube() * 2.0f - Vec3{1, 1, 1};
  if (kind == small) b = a + (b - a) * 0.001f, c = a + (c - a) * 0.001f;
  if (kind == needle) c = a + (b - a) * random.uniform() + random.direction() * 1e-4f;
  const float u = random.uniform(), v = random.uniform();
  Vec3 target = a * (1 - std::max(u, v)) + b * std::min(u, v) + c * std::abs(u - v);
  if (kind == at_edge) target = a * (1 - u) + b * u;
  if (kind == at_corner) target = a;
  Vec3 direction = random.direction();
  if (kind == edge_on) direction = (b - a) * u + (c - a) * v + random.direction() * 1e-5f;
  if (kind == general && v < 0.3f) target = target + random.direction();
  RayQuery query{place(target - direction * (2.0f * random.uniform())), direction, 0.0f, kInfinity, 0.0f};
  if (random.uniform() < 0.3f) query.t_max = 2.0f * place.scale * random.uniform();
  check_triangle(query, {place(a), place(b), place(c)}, frame, size, triangles);
  Box box = Box::empty();
  for (const Vec3& x : {a, b}) box.grow(place(x));
  check_box(query, box, frame, size, boxes);
}

void check_decisions(std::size_t n_cases) {
  const Placement places[] = {{1.0f, 0.0f}, {1e-6f, 0.0f}, {1e6f, 0.0f}, {1.0f, 1e4f}};
  Random random{5};
  for (int kind = 0; kind < n_kinds; ++kind) {
    Worst triangles, boxes;
    for (const Placement& place : places) {
      Box scene = Box::empty();
      for (const float corner : {-1.0f, 1.0f}) scene.grow(place({corner, corner, corner}));
      const Frame frame = frame_of(scene);
      // Far from zero, coordinates are coarse: the caller's ray is what it is, but t is a float in its units.
      const double size = place.scale + std::abs(place.offset);
      for (std::size_t i = 0; i < n_cases / (4 * n_kinds); ++i)
        check_random(random, Kind(kind), place, frame, size, triangles, boxes);
    }
    std::printf("%-12s triangles: decisions %.2g, places %.2g, %zu hits; boxes: %.2g, %.2g, %zu hits\n", kNames[kind],
                triangles.decision, triangles.place, triangles.n_hits, boxes.decision, boxes.place, boxes.n_hits);
    check(triangles.decision < 2e-6 && triangles.place < 4e-6, "triangles are hit where they are");
    check(boxes.decision < 2e-6 && boxes.place < 4e-6, "boxes are hit where they are");
    check(triangles.n_hits > n_cases / 100 && boxes.n_hits > n_cases / 100, "some are hit");
  }
}

/// A sphere of triangles, by halving the edges of an octahedron.
std::vector<Triangle> sphere(int n_halvings) {
  std::vector<Triangle> mesh;
  for (const float x : {-1.0f, 1.0f})
    for (const float y : {-1.0f, 1.0f})
      for (const float z : {-1.0f, 1.0f}) mesh.push_back({{Vec3{x, 0, 0}, Vec3{0, y, 0}, Vec3{0, 0, z}}});
  const auto middle = [](const Vec3& a, const Vec3& b) {
    const Vec3 sum = a + b;
    return sum * (1.0f / float(length_of(sum)));
  };
  for (int i = 0; i < n_halvings; ++i) {
    std::vector<Triangle> finer;
    for (const auto& [corner] : mesh) {
      const auto& [a, b, c] = corner;
      const Vec3 ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Triangle& part : {Triangle{{a, ab, ca}}, {{ab, b, bc}}, {{ca, bc, c}}, {{ab, bc, ca}}})
        finer.push_back(part);
    }
    mesh = finer;
  }
  return mesh;
}

/// Rays from inside a sphere at its corners and at points of its edges always meet it.
void check_watertight() {
  const std::vector<Triangle> mesh = sphere(2);
  Random random{9};
  const Frame frame = frame_of({{-1, -1, -1}, {1, 1, 1}});
  std::size_t n_shared = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Triangle& aimed = mesh[std::size_t(i) % mesh.size()];
    const float s = i % 3 == 0 ? 0.0f : random.uniform();
    const Vec3 target = aimed.corner[0] * (1 - s) + aimed.corner[1] * s;
    const Vec3 origin = random.in_cube() * 0.5f - Vec3{0.25f, 0.25f, 0.25f};
    const Ray ray = prepare({origin, target - origin, 0.0f, kInfinity, 0.0f}, frame);
    std::size_t n_hits = 0;
    for (const Triangle& triangle : mesh) n_hits += test_shape(shape_of(Shape::triangle, triangle), ray, frame).hit;
    check(n_hits > 0, "no ray slips through");
    n_shared += n_hits > 1;
  }
  check(n_shared > 0, "some rays meet an edge that two triangles share");
}

/// Points of a round cone in a box lie in the box of that part, which cannot be made smaller.
void check_clipping() {
  Random random{3};
  std::size_t n_inside = 0, n_empty = 0;
  for (int i = 0; i < 20'000; ++i) {
    RoundCone cone{{random.in_cube(), random.in_cube()}, 0.3f * random.uniform(), 0.3f * random.uniform()};
    if (i % 5 == 0) cone.axis.q = cone.axis.p;
    if (i % 5 == 1) cone.radius0 = cone.radius1 = 0.0f;
    if (i % 5 == 2) cone.radius0 += 1.0f;
    if (i % 5 == 3) cone.radius0 *= 1e-4f, cone.radius1 *= 1e-6f;
    Box box = Box::empty();
    for (int k = 0; k < 2; ++k) box.grow(random.in_cube() * 1.4f - Vec3{0.2f, 0.2f, 0.2f});
    if (i % 3 == 0) {
      // Move a corner of the box to the surface, so that the box is only just met or missed.
      const float s = random.uniform(), own = cone.radius0 + s * (cone.radius1 - cone.radius0);
      const Vec3 shift = cone.axis.point(s) + random.direction() * own - box.lo;
      box = {box.lo + shift, box.hi + shift};
    }
    const Box part = clipped_bounds_of(cone, box);
    n_empty += part.is_empty();
    check(part.is_empty() || box.contains(part), "what is clipped lies in the box");
    const Box again = part.is_empty() ? part : clipped_bounds_of(cone, part);
    for (int k = 0; k < 3 && !part.is_empty(); ++k)
      check(again.lo[k] <= part.lo[k] + 1e-5f && again.hi[k] >= part.hi[k] - 1e-5f, "what is clipped is tight");
    for (int j = 0; j < 100; ++j) {
      const float s = random.uniform(), own = cone.radius0 + s * (cone.radius1 - cone.radius0);
      const Vec3 x = cone.axis.point(s) + random.direction() * (0.9999f * own * std::cbrt(random.uniform()));
      if (!box.contains(Box{x, x})) continue;
      ++n_inside;
      bool holds = !part.is_empty();
      for (int k = 0; k < 3; ++k) holds &= x[k] >= part.lo[k] - 1e-6f && x[k] <= part.hi[k] + 1e-6f;
      check(holds, "clipping loses no point");
    }
  }
  check(n_inside > 10'000 && n_empty > 100, "points lie in boxes, and some boxes are missed");
}

}  // namespace

int main() {
  const char* const given = std::getenv("FASTLINES_TEST_CASES");
  return test::run([=] {
    check_decisions(given ? std::strtoull(given, nullptr, 10) : 400'000);
    check_watertight();
    check_clipping();
  });
}
