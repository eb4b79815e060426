// Compares the exact test of a point with its definition in long double: segments; round cones with tips, with slopes
// near that of a ball, and with one ball inside the other; triangles, flat ones too; boxes. Points lie on them, inside,
// near, and up to a million times as far. Distances, and the distance at the s that is found, are within
// 2⁻²¹ (3 + |p|) + 2⁻²² R of the exact ones, in the frame; R is the larger radius. That is less than half of what
// searches grow by (`PointQuery::eps`, `kRadiusRounding`). Packets have the bits of each primitive alone.
#include <cmath>
#include <cstdio>

#include "check.hpp"
#include "exact_distance.hpp"
#include "fastlines/query/proximity/point_query.hpp"
#include "fastlines/simd/transpose.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Exact, test::Random, test::Real;

namespace {

const Frame kFrame{};  // scale 1, centre 0

float power(Random& random, float from, float to) { return std::pow(10.0f, random.uniform(from, to)); }

Vec3 unit(Random& random) {
  Vec3 d = random.direction();
  if (random.below(4) == 0) d[int(random.below(3))] = 0.0f;
  const float length2 = dot(d, d);
  return length2 > 1e-12f ? d * (1.0f / std::sqrt(length2)) : Vec3{1, 0, 0};
}

/// A radius of nothing, or of up to twice the frame.
float some_radius(Random& random) { return random.below(4) == 0 ? 0.0f : power(random, -6.0f, 0.3f); }

Shape some_shape(Random& random) {
  const Vec3 p = random.in_cube() * 2.0f - Vec3{1, 1, 1};
  const float length = power(random, -6.0f, 0.0f);
  const Vec3 q = random.below(8) == 0 ? p : p + unit(random) * length;
  switch (random.below(6)) {
    case 0: {  // a triangle, perhaps almost flat
      const Vec3 near = random.below(2) ? p + (q - p) * random.uniform(-1, 2) : p;
      return shape_of(Shape::triangle, Triangle{{p, q, near + unit(random) * (length * power(random, -7.0f, 0.0f))}});
    }
    case 1: {
      const Vec3 side{std::fabs(q[0] - p[0]), std::fabs(q[1] - p[1]), std::fabs(q[2] - p[2])};
      return shape_of(Shape::box, Box{p, p + side});
    }
    default: {
      RoundCone cone{{p, q}, some_radius(random), some_radius(random)};
      const Vec3 e = q - p;
      // A radius that grows along the axis by its length, or almost.
      const float one = 1.0f + (random.below(2) ? 1.0f : -1.0f) * power(random, -7.5f, -0.1f);
      if (random.below(3) == 0) cone.radius1 = cone.radius0 + std::sqrt(dot(e, e)) * one;
      if (random.below(2)) std::swap(cone.radius0, cone.radius1);
      return shape_of(Shape::round_cone, cone);
    }
  }
}

/// A point near a shape, or far from it.
Vec3 some_point(const Shape& shape, Random& random) {
  const Vec3 p{shape.numbers[0], shape.numbers[1], shape.numbers[2]};
  const Vec3 q{shape.numbers[3], shape.numbers[4], shape.numbers[5]};
  const float at[] = {0.0f, 1.0f, random.uniform(), random.uniform(-1, 2)};
  Vec3 on = p + (q - p) * at[random.below(4)];
  if (shape.kind() == Shape::triangle && random.below(2))
    on = on + (Vec3{shape.numbers[6], shape.numbers[7], shape.numbers[8]} - on) * random.uniform();
  const float away[] = {0.0f, power(random, -7.0f, 0.0f), power(random, 0.0f, 6.0f)};
  float distance = away[random.below(3)];
  if (shape.kind() == Shape::round_cone && random.below(2)) distance += shape.numbers[6];
  return on + unit(random) * distance;
}

/// The error as a fraction of what is allowed.
double compare(const PointQuery& query, const Shape& shape, const NearestPoint<float>& found) {
  const Exact point(query.p);
  float largest = 0.0f, radius = 0.0f;
  for (int k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(query.p[k]));
  const bool is_cone = shape.kind() == Shape::round_cone, is_surface = is_cone && query.surface;
  if (is_surface) radius = std::max(shape.numbers[6], shape.numbers[7]);
  const Real allowed = 0x1p-21L * (3 + Real(largest)) + 0x1p-22L * radius;
  const Real exact = exact_distance(point, shape, query.surface);
  Real error = std::abs(Real(found.distance) - exact);
  if (is_cone) {
    check(found.s >= 0.0f && found.s <= 1.0f, "s is a place of the axis");
    float axis[8];
    std::copy_n(shape.numbers, 8, axis);
    if (!is_surface) axis[6] = axis[7] = 0.0f;
    error = std::max(error, std::abs(clearance(point, axis, found.s) - exact));
  } else {
    check(found.s == 0.0f, "s is 0 where there is no axis");
  }
  check(found.within == (found.distance <= query.radius) || std::abs(found.distance - query.radius) <= float(allowed),
        "what is within the radius is said to be");
  return double(error / allowed);
}

void check_shapes() {
  Random random{9};
  double worst[3] = {};
  for (int round = 0; round < 40'000; ++round) {
    Shape shapes[kSimdWidth];
    const float* rows[kSimdWidth];
    for (int i = 0; i < kSimdWidth; ++i) {
      shapes[i] = some_shape(random);
      rows[i] = reinterpret_cast<const float*>(&shapes[i]);
    }
    const Vec3 p = some_point(shapes[random.below(kSimdWidth)], random);
    const double point[3] = {p[0], p[1], p[2]};
    const float radius = random.below(4) == 0 ? kInfinity : power(random, -4.0f, 1.0f);
    const PointQuery query = prepare_point(point, radius, random.below(2), kFrame);
    FloatX16 floats[sizeof(Shape) / sizeof(float)];
    transpose_rows(rows, floats);
    const auto packet = nearest_point<Shapes>(query, point_fields<Shapes>(floats, kFrame));
    float s[kSimdWidth], distance[kSimdWidth];
    packet.s.store(s);
    packet.distance.store(distance);
    for (int i = 0; i < kSimdWidth; ++i) {
      const auto found = nearest_point<Shapes>(query, point_fields_of<Shapes>(shapes[i], kFrame));
      const bool within = packet.within.bits() >> i & 1;
      check(found.s == s[i] && found.distance == distance[i] && found.within == within, "a packet has the same bits");
      worst[shapes[i].kind()] = std::max(worst[shapes[i].kind()], compare(query, shapes[i], found));
    }
  }
  std::printf("largest error, as a fraction of what is allowed: cones %.3f, triangles %.3f, boxes %.3f\n", worst[0],
              worst[1], worst[2]);
  for (const double fraction : worst) check(fraction <= 1.0, "distances are exact, but for rounding");
}

/// Segments have the bits of round cones whose radii do not count, and joints are exactly as far from two of them.
void check_segments() {
  Random random{10};
  for (int i = 0; i < 200'000; ++i) {
    const Vec3 p = random.in_cube(), q = p + unit(random) * power(random, -6.0f, 0.0f), r = random.in_cube();
    const Segment first{p, q}, second{q, r};
    const Vec3 at = q + unit(random) * power(random, -7.0f, 2.0f);
    const double point[3] = {at[0], at[1], at[2]};
    const PointQuery query = prepare_point(point, 1.0f, false, kFrame);
    const auto a = nearest_point<Segments>(query, point_fields_of<Segments>(first, kFrame));
    const auto b = nearest_point<Segments>(query, point_fields_of<Segments>(second, kFrame));
    const auto cone = nearest_point<RoundCones>(query, point_fields_of<RoundCones>({first, 0.5f, 0.25f}, kFrame));
    check(a.s == cone.s && a.distance == cone.distance && a.within == cone.within, "the axis of a cone is a segment");
    if (a.s == 1.0f && b.s == 0.0f) check(a.distance == b.distance, "a joint is exactly as far from both lines");
  }
}

}  // namespace

int main() {
  return test::run([] {
    check_shapes();
    check_segments();
  });
}
