// Culls pieces and boxes around points. No piece within a distance, in long double or by the exact test, may be culled;
// nor may its box, as a child of a node, or in a leaf of shapes. Points pass pieces at just that distance, inside and
// outside their surfaces, and up to a million times as far as the scene is large; pieces are long, short, or points,
// and their radii up to twice the scene. Few pieces that are farther away survive.
#include <bit>
#include <cmath>
#include <cstdio>

#include "check.hpp"
#include "exact_distance.hpp"
#include "fastlines/kernels/proximity/point_cull.hpp"
#include "fastlines/layout/block_encoder.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Exact, test::Random, test::Real;

namespace {

float power(Random& random, float from, float to) { return std::pow(10.0f, random.uniform(from, to)); }

Vec3 unit(Random& random) {
  Vec3 d = random.direction();
  if (random.below(4) == 0) d[int(random.below(3))] = 0.0f;
  const float length2 = dot(d, d);
  return length2 > 1e-12f ? d * (1.0f / std::sqrt(length2)) : Vec3{1, 0, 0};
}

/// 16 round cones in the frame, whole, in a leaf of their axes and in one of their boxes, and a node with their boxes.
struct Pieces {
  Frame frame{};  // scale 1, centre 0
  std::vector<RoundCone> cones;
  WideLeaf axes{}, boxes{};
  WideNode node{};

  explicit Pieces(Random& random) {
    const float size = power(random, -5.0f, -0.5f), length = power(random, -4.0f, 0.0f);
    const Vec3 corner = random.in_cube() * 1.6f - Vec3{1, 1, 1};
    const bool has_radius = random.below(2);
    for (std::size_t i = 0; i < kSimdWidth; ++i) {
      const Vec3 a = corner + random.in_cube() * size;
      const Vec3 c = i % 8 == 7 ? a : a + random.direction() * (2 * size * length);
      RoundCone cone{{a, c}, 0.0f, 0.0f};
      if (has_radius) cone.radius0 = size * power(random, -3.0f, 0.3f);
      if (has_radius) cone.radius1 = i % 3 == 0 ? cone.radius0 : i % 3 == 1 ? 0.0f : size * power(random, -3.0f, 0.3f);
      cones.push_back(cone);
    }
    const RoundCones prims(cones);
    frame.overhang = prims.max_radius() * kRadiusRounding;
    std::vector<WideRef> refs;
    for (std::uint32_t i = 0; i < kSimdWidth; ++i) refs.emplace_back(Reference{i});
    encode(prims, refs, {}, axes);
    std::vector<Shape> shapes;
    std::vector<Box> bounds;
    for (std::uint32_t i = 0; i < kSimdWidth; ++i) {
      bounds.push_back(prims.bounds(i));
      if (has_radius) bounds.back() = bounds_of(cones[i]);
      shapes.push_back(shape_of(Shape::box, bounds.back()));
    }
    encode(Shapes{shapes}, refs, bounds, boxes);
    // A node has the planes of a leaf of boxes.
    std::copy_n(boxes.org, 3, node.org);
    node.scale = boxes.scale;
    node.n_children = kSimdWidth;
    std::copy_n(boxes.ends, sizeof boxes.ends, node.planes);
  }

 private:
  template <class P>
  void encode(const P& prims, const std::vector<WideRef>& refs, std::span<const Box> piece_boxes, WideLeaf& to) {
    WideLeaf leaf{};
    leaf.n_refs = kSimdWidth;
    WideNode root{};
    root.n_children = 1;
    Progress progress;
    BlockEncoder<P>(frame, {&root, 1}, {&leaf, 1}, refs, prims, &root, &to, piece_boxes)(1, progress);
  }
};

/// A point whose distance from a piece is about the radius, and the radius.
PointQuery some_query(const Pieces& pieces, Random& random) {
  const RoundCone& cone = pieces.cones[random.below(kSimdWidth)];
  const float s = random.below(3) == 0 ? float(random.below(2)) : random.uniform();
  const Vec3 on = cone.axis.p + (cone.axis.q - cone.axis.p) * s;
  const float own = cone.radius0 + s * (cone.radius1 - cone.radius0);
  const bool surface = random.below(2);
  const float radius = random.below(8) == 0 ? 0.0f : power(random, -7.0f, random.below(8) == 0 ? 6.0f : 0.0f);
  const float away =
      (radius + (surface ? own : 0.0f)) * (1.0f - (random.below(2) ? power(random, -7.0f, -1.0f) : 0.0f));
  const Vec3 at = on + unit(random) * away;
  const double point[3] = {at[0], at[1], at[2]};
  return prepare_point(point, radius, surface, pieces.frame);
}

void check_culling() {
  Random random{11};
  std::uint64_t n_near = 0, n_kept = 0, n_lost = 0;
  for (int round = 0; round < 4000; ++round) {
    const Pieces pieces(random);
    for (int i = 0; i < 64; ++i) {
      const PointQuery query = some_query(pieces, random);
      // The limit may be less than the radius, or negative: inside a surface, the deepest piece is nearest.
      const Exact point(query.p);
      Real exact[kSimdWidth];
      NearestPoint<float> found[kSimdWidth];
      for (int j = 0; j < kSimdWidth; ++j) {
        const Shape cone = shape_of(Shape::round_cone, pieces.cones[std::size_t(j)]);
        exact[j] = exact_distance(point, cone, query.surface);
        found[j] =
            nearest_point<RoundCones>(query, point_fields_of<RoundCones>(pieces.cones[std::size_t(j)], pieces.frame));
      }
      const float limits[] = {query.radius, found[random.below(kSimdWidth)].distance};
      for (const float limit : limits) {
        const float reach = max(limit + query.eps, 0.0f);
        FloatX16 dist2;
        const std::uint32_t of_axes = cull_pieces<RoundCones>(query, pieces.axes, limit);
        const std::uint32_t of_boxes = cull_pieces<Shapes>(query, pieces.boxes, limit);
        const std::uint32_t of_node = cull_boxes(query.p, pieces.node, pieces.node.planes, kSimdWidth, reach, dist2);
        n_kept += std::uint64_t(std::popcount(of_axes));
        float least[kSimdWidth];
        dist2.store(least);
        for (int j = 0; j < kSimdWidth; ++j) {
          if (!(found[j].distance <= limit || exact[j] <= Real(limit))) continue;
          ++n_near;
          n_lost += ~(of_axes & of_boxes & of_node) >> j & 1;
          n_lost += !(least[j] <= reach * reach);
        }
      }
    }
  }
  std::printf("%llu near, %llu kept\n", (unsigned long long)n_near, (unsigned long long)n_kept);
  check(n_lost == 0, "nothing within the distance is culled");
  check(200'000 < n_near && n_near <= n_kept, "many pieces are within the distance");
  check(n_kept < 2 * n_near, "few other pieces survive");
}

}  // namespace

int main() { return test::run(check_culling); }
