// Cuts references: the parts tile the whole, and each box holds its part and stays within the whole's box. The boxes of
// binned parts equal those of cuts at one plane after the other, bit for bit. The box of a triangle's part is tight.
#include "fastlines/references/cut.hpp"

#include <array>
#include <vector>

#include "check.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

bool same(const Box& a, const Box& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

bool holds(const Box& box, const Vec3& point, float slack = 0.0f) {
  for (int k = 0; k < 3; ++k)
    if (point[k] < box.lo[k] - slack || point[k] > box.hi[k] + slack) return false;
  return true;
}

bool holds(const Box& outer, const Box& inner, float slack = 0.0f) {
  return holds(outer, inner.lo, slack) && holds(outer, inner.hi, slack);
}

/// A segment of any direction. Some are perpendicular to an axis; every fourth lies on a lattice, where planes pass
/// through ends.
Segment any_segment(Random& random, int round) {
  Segment segment{random.in_cube(), random.in_cube()};
  if (round % 4 == 1) segment.q[int(random.below(3))] = segment.p[int(random.below(3))];
  if (round % 4 == 2)
    for (Vec3* end : {&segment.p, &segment.q})
      for (int k = 0; k < 3; ++k) (*end)[k] = float(random.below(5)) / 4;
  return segment;
}

void check_sides(const Box& box, int axis, float plane) {
  const Side side = side_of(box, axis, plane);
  check((side == Side::left) == (box.hi[axis] <= plane), "what reaches to the plane is left of it");
  check((side == Side::right) == (box.lo[axis] >= plane && box.hi[axis] > plane), "what begins at the plane is right");
}

template <class P>
BuildRef whole_of(const P& prims) {
  return {Reference{0}, prims.bounds(0)};
}

/// Planes that the box straddles, in ascending order.
std::vector<float> planes_across(Random& random, const Box& box, int axis) {
  std::vector<float> planes;
  for (int i = 0; i < 5; ++i) {
    const float at = random.uniform(box.lo[axis], box.hi[axis]);
    if (side_of(box, axis, at) == Side::both) planes.push_back(at);
  }
  std::sort(planes.begin(), planes.end());
  planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
  return planes;
}

/// Cuts at one plane after the other and compares the boxes of the parts with the bins.
template <class P>
void check_bins(const P& prims, int axis, const std::vector<float>& planes) {
  const BuildRef whole = whole_of(prims);
  std::vector<Box> bins(planes.size() + 1, Box::empty());
  grow_bins(prims, whole, axis, planes, bins.data());
  BuildRef rest = whole;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    BuildRef left = rest;
    cut(prims, axis, planes[i], left, rest);
    check(same(left.box, bins[i]), "a bin is the box of the part that is cut off");
    check(holds(whole.box, left.box), "no part leaves the box of the whole");
    check(left.box.hi[axis] == planes[i] && rest.box.lo[axis] == planes[i], "the plane is a side of both");
  }
  check(same(rest.box, bins.back()), "the last bin is the box of the rest");
}

void check_segment(Random& random, int round) {
  const Segment segment = any_segment(random, round);
  const Segments prims{{&segment, 1}};
  const BuildRef whole = whole_of(prims);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float plane : {whole.box.lo[axis], whole.box.hi[axis], random.uniform()})
      check_sides(whole.box, axis, plane);
    const std::vector<float> planes = planes_across(random, whole.box, axis);
    check_bins(prims, axis, planes);
    for (const float plane : planes) {
      BuildRef left = whole, right = whole;
      cut(prims, axis, plane, left, right);
      const bool rises = segment.ascends(axis);
      const Reference &before = rises ? left.ref : right.ref, &after = rises ? right.ref : left.ref;
      check(before.s0 == whole.ref.s0 && before.s1 == after.s0 && after.s1 == whole.ref.s1, "the pieces tile");
      for (int i = 0; i <= 16; ++i) {
        const float s = float(i) / 16;
        const Box& box = s < before.s1 ? (rises ? left : right).box : (rises ? right : left).box;
        check(holds(box, segment.point(s), 1e-6f), "a piece lies in its box");
      }
    }
  }

  // Clip to any box.
  Box box = Box::empty();
  box.grow(random.in_cube());
  box.grow(random.in_cube());
  const Box clipped = prims.clipped_bounds(0, box);
  check(clipped.is_empty() || holds(box, clipped), "what is clipped lies in the box");
  check(clipped.is_empty() || holds(whole.box, clipped, 1e-6f), "and in that of the whole");
  for (int i = 0; i <= 64; ++i) {
    const Vec3 point = segment.point(float(i) / 64);
    if (holds(box, point)) check(!clipped.is_empty() && holds(clipped, point, 1e-6f), "it holds what lies in the box");
  }
}

using Point = std::array<double, 3>;

/// The corners of the part of a triangle in a box: of the triangle, where its sides cross faces of the box, and where
/// edges of the box cross it. Those at the very boundary may be left out.
std::vector<Point> corners_of_part(const Triangle& triangle, const Box& box) {
  std::vector<Point> found;
  const auto add = [&](const Point& x, int on = -1) {
    for (int k = 0; k < 3; ++k)
      if (k != on && (x[k] < box.lo[k] || x[k] > box.hi[k])) return;
    found.push_back(x);
  };
  Point normal{}, corner[3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) corner[i][k] = triangle.corner[i][k];
  for (int i = 0; i < 3; ++i) {
    const Point &a = corner[i], &b = corner[(i + 1) % 3];
    add(a);
    for (int k = 0; k < 3; ++k)
      for (const double plane : {double(box.lo[k]), double(box.hi[k])}) {
        const double s = (plane - a[k]) / (b[k] - a[k]);
        if (s > 0.0 && s < 1.0) add({a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])}, k);
      }
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    normal[i] = (corner[1][j] - corner[0][j]) * (corner[2][k] - corner[0][k]) -
                (corner[1][k] - corner[0][k]) * (corner[2][j] - corner[0][j]);
  }
  // An edge of the box along axis k crosses the plane of the triangle at x; then x must be on the inner side of each
  // side of the triangle, seen along that axis.
  for (int k = 0; k < 3; ++k)
    for (int which = 0; which < 4; ++which) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      Point x{};
      x[i] = which & 1 ? box.hi[i] : box.lo[i];
      x[j] = which & 2 ? box.hi[j] : box.lo[j];
      x[k] = corner[0][k] - (normal[i] * (x[i] - corner[0][i]) + normal[j] * (x[j] - corner[0][j])) / normal[k];
      int n_inside = 0;
      for (int c = 0; c < 3; ++c) {
        const Point &a = corner[c], &b = corner[(c + 1) % 3];
        n_inside += ((b[i] - a[i]) * (x[j] - a[j]) - (b[j] - a[j]) * (x[i] - a[i])) * normal[k] >= 0.0;
      }
      if (n_inside == 3) add(x);
    }
  return found;
}

/// The box of the part of a triangle is that of its corners.
void check_triangle(const Triangle& triangle, const Box& box) {
  constexpr float kRounding = 1e-5f;
  const Box clipped = triangle.clipped_bounds(box);
  Box expected = Box::empty();
  for (const Point& x : corners_of_part(triangle, box)) expected.grow(Vec3{float(x[0]), float(x[1]), float(x[2])});
  if (expected.is_empty()) {
    check(clipped.is_empty() || clipped.side(clipped.longest_axis()) < kRounding, "no part has no box");
    return;
  }
  check(holds(clipped, expected.lo, kRounding) && holds(clipped, expected.hi, kRounding), "the part lies in its box");
  check(holds(expected, clipped.lo, kRounding) && holds(expected, clipped.hi, kRounding), "the box is tight");
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    for (int round = 0; round < 2000; ++round) {
      check_segment(random, round);
      const Triangle triangle{random.in_cube(), random.in_cube(), random.in_cube()};
      const Box box = any_segment(random, round).bounds();
      check_triangle(triangle, box);
      for (const Shape& shape : {shape_of(Shape::triangle, triangle), shape_of(Shape::box, box)}) {
        const Shapes shapes{{&shape, 1}};
        for (int axis = 0; axis < 3; ++axis) check_bins(shapes, axis, planes_across(random, shapes.bounds(0), axis));
      }
    }
  });
}
