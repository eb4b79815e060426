// Answers queries about points on trees over segments, round cones and shapes, in all ways that points may see them,
// and compares the answers with brute force, bit for bit. A digest of all answers is the same on every machine and for
// every instruction set.
#include <cinttypes>

#include "check.hpp"
#include "fastlines/kernels/proximity/one_point.hpp"
#include "fastlines/query/proximity/brute_force_points.hpp"
#include "fastlines/query/proximity/for_each_point.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

/// The digest of all answers below. If it differs, answers have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0xdd7ebad974eb74db;

constexpr std::size_t kPoints = 300;  // more than a block, and no multiple of 16

/// Points around ends of lines: on them, near, and up to a million sizes away; many at one place.
std::vector<double> points_near(const Lines& lines, double size) {
  Random random{21};
  std::vector<double> points;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Segment& line = lines[i % 5 == 4 ? 0 : random.below(lines.size())];
    const double away = i % 5 == 0 || i % 5 == 4 ? 0.0 : i % 50 == 1 ? 1e6 : std::ldexp(1.0, -int(random.below(14)));
    for (int k = 0; k < 3; ++k) points.push_back(double(line.p[k]) + size * away * (random.uniform() - 0.5));
  }
  return points;
}

/// A radius for each point: 0, small, large and infinite ones.
std::vector<float> radii_of(float size) {
  Random random{22};
  std::vector<float> radii;
  for (std::size_t i = 0; i < kPoints; ++i)
    radii.push_back(i % 7 == 0 ? 0.0f : i % 31 == 1 ? kInfinity : size * std::ldexp(1.0f, -int(random.below(10))));
  return radii;
}

/// A round cone, a triangle or a box in the place of each line, in turn.
std::vector<Shape> shapes_on(const Lines& lines, float size) {
  Random random{23};
  std::vector<Shape> shapes;
  for (const Segment& line : lines) {
    const Triangle triangle{{line.p, line.q, line.p + random.direction() * (0.1f * size)}};
    const RoundCone cone{line, 0.05f * size * random.uniform(), 0.05f * size * random.uniform()};
    if (shapes.size() % 3 == 0)
      shapes.push_back(shape_of(Shape::round_cone, cone));
    else if (shapes.size() % 3 == 1)
      shapes.push_back(shape_of(Shape::triangle, triangle));
    else
      shapes.push_back(shape_of(Shape::box, line.bounds()));
  }
  return shapes;
}

/// Round cones around lines; some have no radius at one end or at both.
std::vector<RoundCone> cones_on(const Lines& lines, float size) {
  Random random{24};
  std::vector<RoundCone> cones;
  for (const Segment& line : lines) {
    const float r0 = random.below(4) ? 0.05f * size * random.uniform() : 0.0f;
    cones.push_back({line, r0, random.below(4) ? 0.05f * size * random.uniform() : 0.0f});
  }
  return cones;
}

/// What points may see: hidden rows, owners of three rows each, and numbers that each point leaves out.
struct Sights {
  std::vector<std::uint8_t> hidden;
  std::vector<std::int64_t> owner, numbers, owners;

  explicit Sights(std::size_t n_rows) {
    Random random{25};
    for (std::size_t row = 0; row < n_rows; ++row) {
      hidden.push_back(random.below(4) == 0);
      owner.push_back(std::int64_t(row / 3));
    }
    for (std::size_t i = 0; i < 2 * kPoints; ++i) {
      numbers.push_back(std::int64_t(random.below(n_rows + 1)) - 1);
      owners.push_back(std::int64_t(random.below(n_rows / 3 + 1)) - 1);
    }
  }

  std::vector<Seen> all() const {
    const Seen::Ignored rows{numbers.data(), 2, {}}, of_owners{owners.data(), 2, owner};
    return {Seen(), Seen{.hidden = hidden}, Seen{.ignored = {rows, of_owners}}, Seen{.owner = owner},
            Seen{.hidden = hidden, .owner = owner, .ignored = {of_owners}}};
  }
};

/// The bits of all answers to a batch.
template <class Search>
std::vector<std::uint32_t> answers_of(const Search& search, const PointBatch& batch, const Seen& seen,
                                      unsigned n_threads) {
  Progress progress;
  const PointsQuery<Search> query{search, batch, seen, n_threads, progress};
  Answers answers;
  const auto add = [&](std::size_t n, const float* distance, const std::int64_t* row, const float* s) {
    for (std::size_t i = 0; i < n; ++i) {
      answers.add(distance[i]);
      answers.add(row[i]);
      answers.add(s[i]);
    }
  };
  for (const std::size_t k : {1, 8}) {
    const std::size_t n = k * kPoints;
    std::vector<float> distance(n), s(n);
    std::vector<std::int64_t> row(n);
    query.find_nearest(k, {distance.data(), row.data(), s.data()});
    add(n, distance.data(), row.data(), s.data());
  }
  const PointLists lists = query.list();
  add(lists.row.size(), lists.distance.data(), lists.row.data(), lists.s.data());
  std::vector<std::int64_t> counts(kPoints);
  query.count(counts.data());
  for (std::size_t i = 0; i < kPoints; ++i) {
    check(counts[i] == lists.offsets[i + 1] - lists.offsets[i], "as many are counted as are listed");
    answers.add(counts[i]);
  }
  return answers.words;
}

/// Compare the answers of a tree with those of brute force. The tree is over `built`, and queries are on `prims`.
template <class Built, class P>
void compare(const Scene& scene, const Built& built, const P& prims, const PointBatch& points, std::uint64_t& digest) {
  Progress progress;
  const Tree tree = build(built, progress);
  const WideBvh wide = collapse(tree.nodes, tree.refs, prims, {.radius_hint = 0.001}, 1, progress);
  const WideBvhView<P> view = view_of(wide, prims);
  const PointSearch<P> search(view, wide.leaves.size());
  const BruteForcePoints<P> brute{prims, view.frame};
  const Sights sights(prims.size());
  for (const bool surface : {false, true}) {
    if (surface && !kHasRadius<P> && !MixedPrimitive<P>) continue;
    for (const Seen& seen : sights.all()) {
      const PointBatch batch{points.coordinates, points.radius, surface};
      const std::vector<std::uint32_t> expected = answers_of(brute, batch, seen, 1);
      for (const std::uint32_t word : expected) digest = (digest ^ word) * 0x100'0000'01b3;
      const bool is_same = answers_of(search, batch, seen, surface ? 1 : 3) == expected;
      if (!is_same) std::printf("%s: scene \"%s\", %s differ\n", kSimd, scene.name.c_str(), P::kKind);
      check(is_same, "what is near points is what brute force finds");
    }
  }
}

/// Lines that share an end, in an order that is not that of space: all are equally far from points beyond it.
Scene spokes() {
  Random random{26};
  Scene scene{"spokes", {}};
  while (scene.lines.size() < 3000) {
    const Vec3 d = random.direction();
    scene.lines.push_back({{0.0f, 0.0f, 0.0f}, {-std::fabs(d[0]), d[1], d[2]}});
  }
  return scene;
}

}  // namespace

int main() {
  return run([] {
    std::uint64_t digest = 0xcbf2'9ce4'8422'2325;
    for (const Scene& scene : scenes()) {
      const Box box = bounds_of_all(Segments{scene.lines});
      const auto size = std::max(float(box.side(box.longest_axis())), 1e-9f);
      const std::vector<double> points = points_near(scene.lines, size);
      const std::vector<float> radii = radii_of(size);
      const PointBatch batch{points, radii, false};
      const std::vector<RoundCone> cones = cones_on(scene.lines, size);
      const std::vector<Shape> shapes = shapes_on(scene.lines, size);
      compare(scene, Segments{scene.lines}, Segments{scene.lines}, batch, digest);
      compare(scene, Segments{scene.lines}, RoundCones(cones), batch, digest);
      compare(scene, Shapes{shapes}, Shapes{shapes}, batch, digest);
    }
    {
      const Scene scene = spokes();
      std::vector<double> points(3 * kPoints, 9.0);
      std::vector<float> radii(kPoints, 0.75f);
      for (std::size_t i = 0; i < 3 * kPoints; i += 90) {
        points[i] = 0.5;
        points[i + 1] = points[i + 2] = 0.0;
      }
      compare(scene, Segments{scene.lines}, Segments{scene.lines}, {points, radii, false}, digest);
    }
    if (digest != kDigest) std::printf("the digest of all answers is %016" PRIx64 "\n", digest);
    check(digest == kDigest, "the digest of all answers is unchanged");
  });
}
