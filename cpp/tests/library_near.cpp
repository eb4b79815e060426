// The library's queries about points and pairs: on every instruction set of this machine, each has the answers of brute
// force, one point at a time and in batches. Lines and strands that are left out, input that is refused, and threads.
#include <cmath>
#include <thread>

#include "fastlines/query/proximity/all_pairs.hpp"
#include "library.hpp"

using namespace fastlines;
using test::Random, test::Scene;

namespace {

bool same(const fl::NearLine& a, const fl::NearLine& b) {
  return a.distance == b.distance && a.prim == b.prim && a.u == b.u;
}
template <class A>
bool same_lines(const A& found, const std::vector<fl::NearLine>& expected, std::size_t most = ~std::size_t(0)) {
  bool equal = found.size() == std::min(most, expected.size());
  for (std::size_t i = 0; equal && i < found.size(); ++i) equal = same(found[i], expected[i]);
  return equal;
}

/// Points on lines, near them, at their ends, between them and far away.
std::vector<fl::Vec3d> points_near(const test::Lines& lines, float size) {
  Random random{31};
  std::vector<fl::Vec3d> points;
  for (int i = 0; i < 60; ++i) {
    const Segment& line = lines[random.below(lines.size())];
    const float away[] = {0.0f, 1e-4f, 0.02f, 1.0f, 1e3f};
    Vec3 at = line.point(i % 3 == 0 ? float(random.below(2)) : random.uniform());
    at = at + random.direction() * (size * away[i % 5]);
    points.push_back({at[0], at[1], at[2] + (i % 7 == 0 ? 1e-9 * size : 0.0)});
  }
  return points;
}

/// A tree of the library, and brute force over its lines.
template <class P>
struct Compared {
  const fl::Tree& tree;
  const P& prims;
  Frame frame = frame_of(bounds_of_all(prims));

  std::vector<fl::NearLine> expected(const fl::Vec3d& point, float radius, fl::To to, const Seen& seen = Seen()) const {
    const double at[] = {point.x, point.y, point.z};
    const PointQuery query = prepare_point(at, radius, to == fl::To::surface && max_radius_of(prims) > 0, frame);
    std::vector<Neighbour> list;
    WithinOfPoint within(query, 0, seen, false, list);
    Progress progress;
    Checkpoint checkpoint(progress);
    typename BruteForcePoints<P>::Scratch scratch;
    BruteForcePoints<P>{prims, frame}(query, within, scratch, checkpoint);
    within.finish();
    std::vector<fl::NearLine> lines;
    for (const Neighbour& each : list)
      lines.push_back({float(double(each.distance) / double(frame.scale)), each.row, each.s});
    return lines;
  }

  void check_points(const std::vector<fl::Vec3d>& points, float radius, fl::To to) const {
    constexpr std::size_t k = 3;
    const fl::PointOptions options{.to = to, .n_threads = 2, .progress = {}};
    const std::vector<float> radii(points.size(), radius);
    const fl::NearLines nearest = tree.nearest({points}, fl::infinity, options);
    const fl::NearLines most = tree.k_nearest({points}, k, radii, options);
    const fl::NearLists within = tree.within({points}, radii, options);
    const auto counts = tree.count_within({points}, radius, options);
    check(nearest.size() == points.size() && within.n_points() == points.size(), "an answer for each point");
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto all = expected(points[i], fl::infinity, to), near = expected(points[i], radius, to);
      const auto first = [](const std::vector<fl::NearLine>& of) { return of.empty() ? fl::NearLine() : of[0]; };
      check(same(tree.nearest(points[i], fl::infinity, to), first(all)), "the nearest line of a point");
      check(same(tree.nearest(points[i], radius, to), first(near)), "the nearest line within a distance");
      check(same_lines(tree.k_nearest(points[i], k, fl::infinity, to), all, k), "the k nearest lines");
      check(same_lines(tree.within(points[i], radius, to), near), "the lines within a radius");
      check(tree.count_within(points[i], radius, to) == near.size(), "their number");
      check(same(nearest[i], first(all)), "the nearest lines of a batch");
      for (std::size_t j = 0; j < k; ++j)
        check(same(most[i * k + j], j < near.size() ? near[j] : fl::NearLine()), "the k nearest lines of a batch");
      check(same_lines(within[i], near), "the lines within a radius of a batch");
      check(std::size_t(counts[i]) == near.size(), "their numbers of a batch");
    }
  }

  /// Without line 0, the nearest one, and the strand of the last one.
  void check_ignored(const std::vector<fl::Vec3d>& points, std::span<const std::int64_t> strands) const {
    for (const fl::Vec3d& position : points) {
      const std::int64_t lines[] = {0, -1, tree.nearest(position).prim}, strand[] = {strands.back()};
      const Seen seen{.ignored = {{lines, 3, {}}, {strand, 1, strands}}};
      const auto left = expected(position, fl::infinity, fl::To::surface, seen);
      fl::Point point(position);
      point.ignore = lines;
      point.ignore_strands = strand;
      const fl::Points one{{&position, 1}, lines, strand};
      check(same(tree.nearest(point), left.empty() ? fl::NearLine() : left[0]), "a point leaves lines out");
      check(same(tree.nearest(one)[0], tree.nearest(point)), "a batch leaves lines out");
      check(same_lines(tree.k_nearest(point, 5), left, 5), "the k nearest of the others");
    }
  }

  void check_pairs(float radius, fl::To to) const {
    const bool surface = to == fl::To::surface && max_radius_of(prims) > 0;
    for (const bool is_self : {true, false}) {
      const PairQuery query{axes_of(prims), axes_of(prims), is_self, frame, radius, surface, {}};
      Progress progress;
      const PairColumns expected = all_pairs<float>(query, 1, progress);
      const fl::PairOptions options{.to = to, .skip_neighbours = 0, .n_threads = 2, .progress = {}};
      const fl::Pairs found = is_self ? tree.pairs(radius, options) : tree.pairs(radius, tree, options);
      bool equal = found.size() == expected.i.size();
      for (std::size_t at = 0; equal && at < found.size(); ++at)
        equal = found.i[at] == expected.i[at] && found.j[at] == expected.j[at] && found.s[at] == expected.s[at] &&
                found.t[at] == expected.t[at] && found.distance[at] == expected.distance[at];
      check(equal, "pairs are those of brute force");
    }
  }

  void check_all(const std::vector<fl::Vec3d>& points, float size) const {
    for (const fl::To to : {fl::To::surface, fl::To::axis}) {
      for (const float radius : {0.0f, 0.05f * size}) check_points(points, radius, to);
      check_pairs(0.02f * size, to);
    }
  }
};

void check_scene(const Scene& scene) {
  const Segments prims{scene.lines};
  const Box box = bounds_of_all(prims);
  const float size = float(std::max(box.side(box.longest_axis()), 1e-6));
  const std::vector<fl::Segment> segments = segments_of(scene.lines);
  const std::vector<fl::RoundCone> cones = cones_of(segments, size);
  std::vector<RoundCone> core_cones;
  for (std::size_t i = 0; i < cones.size(); ++i)
    core_cones.push_back({scene.lines[i], cones[i].radius_p, cones[i].radius_q});
  const std::vector<fl::Vec3d> points = points_near(scene.lines, size);
  static int next = 0;
  fl::BuildOptions options;
  options.method = fl::Method(next++ % 6);
  std::vector<std::int64_t> strands;
  for (std::size_t i = 0; i < segments.size(); ++i) strands.push_back(std::int64_t(i / 5) - 1);
  options.strands = strands;
  const fl::Tree of_segments = fl::build(segments, options), of_cones = fl::build(cones, options);
  const RoundCones round(core_cones);
  const Compared<Segments> thin{of_segments, prims};
  const Compared<RoundCones> thick{of_cones, round};
  thin.check_all(points, size);
  thick.check_all(points, size);
  thin.check_ignored(points, strands);
  thick.check_ignored(points, strands);
}

/// Pairs along strands: neighbours, closed strands, two trees, and trees of different instruction sets.
void check_strands() {
  std::vector<fl::Segment> square;
  const fl::Vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (int i = 0; i < 4; ++i) square.push_back({corners[i], corners[(i + 1) % 4]});
  square.push_back({{0, 0, 0.5f}, {1, 0, 0.5f}});
  const std::vector<std::int64_t> strands{2, 2, 2, 2, -1};
  fl::BuildOptions build;
  build.strands = strands;
  const fl::Tree tree = fl::build(square, build);
  fl::PairOptions options;
  const auto n_pairs = [&](float radius) { return tree.pairs(radius, options).size(); };
  check(n_pairs(0.5f) == 3 && n_pairs(1.0f) == 5, "neighbours are left out");
  const fl::Pairs found = tree.pairs(0.5f);
  check(found[0].i == 0 && found[0].j == 4 && found[0].distance == 0.5f && found[1].s == 0.0f, "a pair");
  options.skip_neighbours = 0;
  check(n_pairs(0.5f) == 7, "neighbours are pairs, too");
  options.skip_neighbours = 2;
  check(n_pairs(1.0f) == 3, "more neighbours are left out");
  options = {};
  options.skip_strand = true;
  check(n_pairs(1.0f) == 3, "a strand is left out");
  check(!message_of<fl::InputError>([&] { tree.pairs(1.0f, tree, options); }).empty(), "strands of two trees differ");
  check(tree.pairs(0.0f, tree).size() == 13, "pairs of two trees are all found");
  for (const char* simd : {"avx2", "sse42"}) {
    if (!message_of<fl::InputError>([&] { fl::set_simd(simd); }).empty()) continue;
    const fl::Tree other = fl::build(square);
    fl::set_simd(nullptr);
    check(tree.pairs(0.5f, other).size() == 19 && other.pairs(0.5f, tree).size() == 19, "instruction sets may differ");
  }
  check(tree.pairs(1.0f, fl::Tree()).size() == 0 && fl::Tree().pairs(1.0f).size() == 0, "an empty tree has no pairs");
}

void check_places() {
  const fl::Tree tree = fl::build(std::vector<fl::RoundCone>{{{-1, 0, 0}, {1, 0, 0}, 0.5f, 0.5f}});
  const auto is = [](const fl::Vec3d& v, double x, double y, double z) { return v.x == x && v.y == y && v.z == z; };
  const fl::Vec3d above{0.25, 0, 3}, on_axis{0, 0, 0};
  check(is(tree.place(above, tree.nearest(above)), 0.25, 0, 0.5), "the nearest point of a surface");
  check(is(tree.place(above, tree.nearest(above), fl::To::axis), 0.25, 0, 0), "the nearest point of an axis");
  check(is(tree.place(on_axis, tree.nearest(on_axis)), 0, 0, 0.5), "that of a point of the axis lies across it");
  check(std::isnan(tree.place(above, fl::NearLine()).x), "no point of no line");
}

void check_input() {
  const auto refuses = [](auto&& call, const char* what) {
    const std::string why = message_of<fl::InputError>(call);
    if (why.find(what) == std::string::npos) std::printf("%s: %s\n", what, why.c_str());
    return why.find(what) != std::string::npos;
  };
  const fl::Tree tree = fl::build(std::vector<fl::Segment>{{{-1, 0, 0}, {1, 0, 0}}}), none;
  const double nan = std::nan("");
  const std::vector<fl::Vec3d> good(3), bad{{}, {0, nan, 0}};
  check(refuses([&] { tree.nearest({nan, 0, 0}); }, "the point has a coordinate that is not finite"), "NaN");
  check(refuses([&] { tree.nearest({1e30, 0, 0}); }, "farther from the scene than 2e+12"), "a point far away");
  check(refuses([&] { tree.nearest({bad}); }, "point 1 has a coordinate"), "NaN in a batch");
  check(refuses([&] { tree.nearest({0, 0, 0}, -1); }, "a max_distance of -1"), "a negative distance");
  check(refuses([&] { tree.within({0, 0, 0}, float(nan)); }, "a radius of nan"), "a radius that is NaN");
  check(refuses([&] { tree.count_within({0, 0, 0}, fl::infinity); }, "from 0 to 2e+12"), "a radius without an end");
  check(refuses([&] { tree.within({good}, std::vector<float>(2)); }, "has 2 numbers"), "radii that do not match");
  check(refuses([&] { tree.nearest({0, 0, 0}, 1, fl::To(7)); }, "unknown fl::To"), "an unknown enumerator");
  check(refuses([&] { tree.pairs(-1); }, "a radius of -1"), "a negative radius of pairs");
  check(refuses([&] { tree.nearest(fl::Points{{(const fl::Vec3d*)nullptr, 2}}); }, "null"), "null points");
  const std::int64_t unknown[] = {1};
  check(refuses([&] { tree.nearest(fl::Points{good, unknown}); }, "ignore names 1"), "a line that is not there");
  check(!none.nearest({1, 2, 3}) && none.within({1, 2, 3}, 1).empty(), "an empty tree has no lines");
  check(none.nearest({good})[2].prim == -1 && none.within({good}, 1.0f).n_points() == 3, "nor in a batch");
  check(tree.nearest(fl::Points()).size() == 0 && tree.within(fl::Points(), 1.0f).n_points() == 0, "no points");
  check(tree.k_nearest({0, 0, 0}, 0).empty() && tree.k_nearest({0, 0, 0}, ~std::size_t(0)).size() == 1, "any k");
  check(tree.k_nearest({good}, 0).size() == 0, "no lines of a batch");
  bool is_refused = false;
  try {
    tree.k_nearest({good}, ~std::size_t(0) / 8);
  } catch (const std::bad_alloc&) {
    is_refused = true;
  }
  check(is_refused, "more lines than fit into memory");
  fl::PointOptions options;
  options.progress = [](double) { return false; };
  const fl::Tree hair = fl::build(segments_of(test::hair(400)));
  const std::vector<fl::Vec3d> many(100'000, {0.5, 0.5, 0.5});
  check(!message_of<fl::Cancelled>([&] { hair.within({many}, 1.0f, options); }).empty(), "a query can be cancelled");
}

void check_threads() {
  const test::Lines lines = test::hair(150);
  const fl::Tree tree = fl::build(segments_of(lines));
  const std::vector<fl::Vec3d> points = points_near(lines, 1.0f);
  const auto ask = [&](std::vector<fl::NearLine>& to) {
    std::vector<fl::NearLine> near;
    for (const fl::Vec3d& point : points) {
      to.push_back(tree.nearest(point));
      tree.k_nearest(point, 4, near);
      to.insert(to.end(), near.begin(), near.end());
      tree.within(point, 0.05f, near);
      to.insert(to.end(), near.begin(), near.end());
    }
  };
  std::vector<fl::NearLine> expected;
  ask(expected);
  std::vector<std::vector<fl::NearLine>> found(4);
  std::vector<std::thread> threads;
  for (auto& of_thread : found) threads.emplace_back([&] { ask(of_thread); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& of_thread : found) check(same_lines(of_thread, expected), "threads do not disturb each other");
}

void check_near() {
  check_strands();
  check_places();
  check_input();
  check_threads();
  for (const char* simd : {"avx512", "avx2", "sse42", "neon", "portable"}) {
    if (!message_of<fl::InputError>([&] { fl::set_simd(simd); }).empty()) continue;
    std::printf("%s\n", simd);
    for (const Scene& scene : test::scenes())
      if (scene.lines.size() <= 300) check_scene(scene);
  }
  fl::set_simd(nullptr);
}

}  // namespace

int main() { return test::run(check_near); }
