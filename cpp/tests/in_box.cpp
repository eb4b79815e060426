// Lists what is in boxes, of all sizes, on trees over segments, round cones and shapes, and compares it with brute
// force. A digest of all lists is the same on every machine and for every instruction set.
#include <cinttypes>

#include "check.hpp"
#include "fastlines/kernels/proximity/in_box.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

/// The digest of all lists below. If it differs, answers have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0x4d0e8c4eda3f33ef;

/// Boxes around ends of lines: points, boxes from end to end, and boxes of all sizes, some without a side.
std::vector<Region> regions_of(const Lines& lines, double size) {
  Random random{11};
  std::vector<Region> regions;
  while (regions.size() < 160) {
    const Vec3& start = lines[random.below(lines.size())].p;
    const Vec3& other = lines[random.below(lines.size())].q;
    const std::size_t i = regions.size();
    Region& region = regions.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const double reach = size * std::ldexp(1.0, -int(random.below(14))) * random.uniform();
      const double end = i % 4 == 0 ? start[k] : i % 4 == 1 ? other[k] : start[k] + reach;
      region.lo[k] = std::min<double>(start[k], end);
      region.hi[k] = std::max<double>(start[k], end);
    }
    if (i % 8 == 5) region.lo[i / 8 % 3] = -std::numeric_limits<double>::infinity();
    if (i % 8 == 6) region.hi[i / 8 % 3] = std::numeric_limits<double>::infinity();
  }
  return regions;
}

/// A round cone, a triangle or a box in the place of each line, in turn.
std::vector<Shape> shapes_on(const Lines& lines, float size) {
  Random random{12};
  std::vector<Shape> shapes;
  for (const Segment& line : lines) {
    Box box = Box::empty();
    box.grow(line.p);
    box.grow(line.q);
    const Triangle triangle{{line.p, line.q, line.p + random.direction() * (0.1f * size)}};
    const RoundCone cone{line, 0.05f * size * random.uniform(), 0.05f * size * random.uniform()};
    if (shapes.size() % 3 == 0)
      shapes.push_back(shape_of(Shape::round_cone, cone));
    else if (shapes.size() % 3 == 1)
      shapes.push_back(shape_of(Shape::triangle, triangle));
    else
      shapes.push_back(shape_of(Shape::box, box));
  }
  return shapes;
}

/// Round cones around lines; some have no radius at one end or at both.
std::vector<RoundCone> cones_on(const Lines& lines, float size) {
  Random random{13};
  std::vector<RoundCone> cones;
  for (const Segment& line : lines) {
    const float r0 = random.below(4) ? 0.1f * size * random.uniform() : 0.0f;
    cones.push_back({line, r0, random.below(4) ? 0.1f * size * random.uniform() : 0.0f});
  }
  return cones;
}

struct Digest {
  std::uint64_t value = 0xcbf2'9ce4'8422'2325;
  std::size_t n_found = 0;

  void add(const InBoxLists& lists) {
    for (const auto* numbers : {&lists.offsets, &lists.prims})
      for (const std::int64_t number : *numbers) value = (value ^ std::uint64_t(number)) * 0x100'0000'01b3;
    n_found += lists.prims.size();
  }
};

/// Compare the lists of a tree with those of brute force. The tree is over `built`, and queries are on `prims`.
template <class Built, class P>
void compare(const Scene& scene, const Built& built, const P& prims, const std::vector<Region>& regions,
             Digest& digest) {
  Progress progress;
  const Tree tree = build(built, progress);
  const WideBvh wide = collapse(tree.nodes, tree.refs, prims, {.radius_hint = 0.001}, 1, progress);
  const WideBvhView<P> view = view_of(wide, prims);
  for (const bool surface : {false, true}) {
    const InBoxLists expected =
        list_in_boxes(regions, prims.size(), 1, progress, [&] { return BruteForceInBox<P>{prims, surface}; });
    digest.add(expected);
    for (const unsigned n_threads : {1u, 3u}) {
      const InBoxLists given =
          list_in_boxes(regions, prims.size(), n_threads, progress, [&] { return InBoxSearch<P>(view, surface); });
      const bool is_same = given.offsets == expected.offsets && given.prims == expected.prims;
      if (!is_same) std::printf("%s: scene \"%s\", %s differ\n", kSimd, scene.name.c_str(), P::kKind);
      check(is_same, "what is in boxes is what brute force finds");
    }
  }
}

}  // namespace

int main() {
  return run([] {
    Digest digest;
    for (const Scene& scene : scenes()) {
      const Box box = bounds_of_all(Segments{scene.lines});
      const auto size = float(box.side(box.longest_axis()));
      const std::vector<Region> regions = regions_of(scene.lines, size);
      const std::vector<RoundCone> cones = cones_on(scene.lines, size);
      const std::vector<Shape> shapes = shapes_on(scene.lines, size);
      compare(scene, Segments{scene.lines}, Segments{scene.lines}, regions, digest);
      compare(scene, Segments{scene.lines}, RoundCones(cones), regions, digest);
      compare(scene, Shapes{shapes}, Shapes{shapes}, regions, digest);
    }
    check(digest.n_found > 1000, "something is in the boxes");
    if (digest.value != kDigest) std::printf("the digest of all lists is %016" PRIx64 "\n", digest.value);
    check(digest.value == kDigest, "the digest of all lists is unchanged");
  });
}
