// Runs the kernels for GPUs on the host, and compares all answers with brute force, bit for bit: all kinds of
// primitives, all queries, rays of all kinds, in order and shuffled, with a spread and without.
// With FASTLINES_EMULATE_WARPS, each lane is a fiber.
#include <algorithm>
#include <cinttypes>
#include <numeric>

#include "chains.hpp"
#include "check.hpp"
#include "fastlines/primitives/spread_cones.hpp"

#if !defined(FASTLINES_EMULATE_WARPS)
#define FASTLINES_EMULATE_WARPS 0
#endif
#if FASTLINES_EMULATE_WARPS
#include "emulated_warps.hpp"
#endif
#include "emulated_device.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

constexpr bool kEmulatesWarps = FASTLINES_EMULATE_WARPS;
std::size_t n_decisions = 0, n_answers = 0, n_differ = 0, n_repeated = 0;

/// Adds the lists of hits, or the first hits if there are no offsets.
Answers answers_of(const OwnedHits& hits, At at) {
  Answers answers;
  const bool lists = !hits.offsets.empty();
  const std::size_t n_rays = lists ? hits.offsets.size() - 1 : hits.t.size();
  for (std::size_t ray = 0; ray < n_rays; ++ray) {
    const std::size_t begin = lists ? std::size_t(hits.offsets[ray]) : ray;
    const std::size_t end = lists ? std::size_t(hits.offsets[ray + 1]) : ray + 1;
    for (std::size_t i = begin; i < end; ++i) put(hits, i, at, answers);
    answers.end();
  }
  return answers;
}

template <class Numbers>
Answers answers_of(const Numbers& numbers) {
  Answers answers;
  for (const auto number : numbers) {
    answers.add(std::int64_t(number));
    answers.end();
  }
  return answers;
}

/// The answers of the kernels; those of `k_nearest` by t, or by distance with `Keep::nearest`.
template <class P, class Where>
Answers answer_on_device(const EmulatedDevice<P>& device, Ask query, Where where, Keep keep) {
  const At at = where.at;
  if (query == Ask::first) return answers_of(device.first(where), at);
  if (query == Ask::any) return answers_of(device.any(at));
  if (query == Ask::count) return answers_of(device.count(at));
  if (query == Ask::all) return answers_of(device.template list<Keep::all>(where), at);
  if (keep == Keep::first) return answers_of(device.template list<Keep::first>(where, kNearest), at);
  return answers_of(device.template list<Keep::nearest>(where, kNearest), at);
}

/// The nearest hits by brute force.
template <class P>
Answers nearest_by_brute_force(const Brute<P>& brute, At at) {
  HitAssembler lists(brute.rays.size(), has_exit(at));
  list_hits(brute.search, brute.rays, 1, brute.progress, lists, at, Keep::nearest, kNearest);
  OwnedHits hits;
  const auto offsets = lists.offsets();
  hits.offsets.assign(offsets.begin(), offsets.end());
  hits.columns(std::size_t(offsets.back()));
  for (std::size_t i = 0; i < hits.t.size(); ++i) {
    hits.t[i] = lists.t[i];
    hits.u[i] = lists.u[i];
    hits.distance[i] = lists.distance[i];
    hits.prim[i] = lists.prim[i];
    if (has_exit(at)) hits.t_out[i] = lists.t_out[i];
  }
  return answers_of(hits, at);
}

/// Compare one query on a scene.
template <class P, class D>
void check_query(const Brute<P>& brute, const EmulatedDevice<D>& device, const Case& test_case, Keep keep,
                 const std::string& what) {
  const auto [name, query, at] = test_case;
  const Answers expected = keep == Keep::first ? answer(brute, test_case) : nearest_by_brute_force(brute, at);
  const Answers given = at == At::closest ? answer_on_device(device, query, FixedAt<At::closest>(), keep)
                                          : answer_on_device(device, query, SurfaceAt(at), keep);
  n_answers += brute.rays.size();
  n_decisions += brute.rays.size() * brute.search.prims.size();
  for (std::size_t ray = 0; ray < brute.rays.size(); ++ray) {
    if (std::ranges::equal(given.of(ray), expected.of(ray))) continue;
    if (n_differ++ < 10) std::printf("%s, query \"%s\": ray %zu differs\n", what.c_str(), name, ray);
  }
}

/// Rays from so far away that hits at many places have the same t in units of the ray: the first is that of the lowest
/// id, which may be in a node that the ray enters later.
Rays rays_from_afar(const Lines& lines, float size) {
  Random random{8};
  Rays rays{.name = "from afar", .origins = {}, .directions = {}, .radius = {}};
  for (int i = 0; i < 90; ++i) {
    const Segment& line = lines[random.below(lines.size())];
    Vec3 d{0, 0, 0};
    d[std::size_t(i % 3)] = i % 2 ? size : -size;
    rays.origins.push_back(line.p + (line.q - line.p) * random.uniform() - d * (i % 4 < 2 ? 1e6f : 1e8f));
    rays.directions.push_back(d);
    rays.radius.push_back((i % 5 ? 0.002f : 0.1f) * size);
  }
  return rays;
}

/// Rays with a spread: one for all rays of a picture, or each its own.
Rays spread(Rays rays) {
  Random random{9};
  const float spreads[] = {0.0f, 1e-4f, 0.01f, 0.3f};
  rays.spread = {0.005f};
  if (rays.name == "scattered") rays.spread.resize(rays.origins.size());
  for (float& one : rays.spread)
    if (rays.spread.size() > 1) one = spreads[random.below(4)];
  if (rays.name == "from afar") rays.spread = {1e-8f};
  return rays;
}

/// Run all queries on a scene, with kernels for the primitives D. The layout is that of `built`, which has the same
/// primitives.
template <class D, class Built, class P>
void check_scene(const std::string& name, const Lines& lines, const Built& built, const P& prims) {
  Progress progress;
  const Tree tree = build(built, progress);
  const WideBvh wide = collapse(tree.nodes, tree.refs, built, {.radius_hint = 0.001}, 1, progress);
  const WideBvhView<P> view = view_of(wide, prims);
  const bool has_repeats = D::kHasBoxes && wide.refs.size() > prims.size();
  n_repeated += has_repeats;
  const std::size_t room = stack_room(wide.nodes);
  check(room <= FASTLINES_STACK, "the stack has room for the tree");
  deepest_stack = 0;
  const Box& box = tree.nodes[0].box;
  std::vector<Rays> all_rays = rays_of(lines, box);
  all_rays.push_back(rays_from_afar(lines, float(box.side(box.longest_axis()))));
  for (Rays& rays : all_rays) {
    if constexpr (kHasSpread<D>) rays = spread(rays);
    const RayBatch batch = rays.batch();
    // Threads may take rays in any order.
    std::vector<std::uint32_t> order;
    if (rays.name == "scattered") {
      order.resize(batch.size());
      std::iota(order.rbegin(), order.rend(), 0u);
    }
    const EmulatedDevice<D> device{scene_of(view), device_rays_of(batch, order), has_repeats};
    const Brute<P> brute{{prims, view.frame}, batch, 1, progress};
    const std::string where = P::kKind + (" \"" + name) + "\", rays \"" + rays.name + '"';
    for (const Case& test_case : kCases)
      for (const Keep keep : {Keep::first, Keep::nearest}) {
        if (keep == Keep::nearest && test_case.query != Ask::k_nearest) continue;
        if (has_exit(test_case.at) && kHasSpread<D>) continue;
        check_query(brute, device, test_case, keep, where);
      }
  }
  check(std::size_t(deepest_stack) <= room, "no stack is deeper than foreseen");
}

/// Chains of nodes fill the stack as far as foreseen, and no farther.
void check_chains() {
  for (const ChildOfDepth child : {first_child, child_in_turn, second_child}) {
    const Chain chain(child);
    const RayBatch rays = chain.rays();
    const EmulatedDevice<DeviceSegments> device{scene_of(chain.view()), device_rays_of(rays, {}), false};
    deepest_stack = 0;
    const auto first = device.first(FixedAt<At::closest>());
    const auto found = device.any(At::closest);
    for (int i = 0; i < kRays; ++i) {
      check((first.prim[std::size_t(i)] == 0) == Chain::hits(i), "the first hit in a chain is right");
      check((found[std::size_t(i)] == 1) == Chain::hits(i), "whether there is a hit in a chain is right");
    }
    const auto room = int(stack_room(chain.nodes));
    check(room == kDepth + 1 && deepest_stack <= room, "no stack is deeper than foreseen");
    // Of children that the ray enters at the same t, the last comes first; so here the first ones wait.
    if (child == second_child && !kEmulatesWarps) check(deepest_stack == room, "a stack is as deep as foreseen");
  }
}

/// Round cones of all sizes around lines: capsules, cones, balls inside one another, and lines without a radius.
std::vector<RoundCone> cones_around(const Lines& lines) {
  Random random{6};
  std::vector<RoundCone> cones;
  for (const Segment& line : lines) {
    const Vec3 along = line.q - line.p;
    const float length = std::sqrt(dot(along, along)), shares[] = {0.0f, 0.01f, 0.1f, 0.6f};
    const float radius0 = shares[random.below(4)] * (length > 0.0f ? length : 0.01f);
    const float radius1 = random.below(3) == 0 ? radius0 : 2.0f * random.uniform() * radius0;
    cones.push_back({line, radius0, radius1});
  }
  return cones;
}

/// Shapes along lines: each a round cone, a triangle, a box, or a box without a volume.
std::vector<Shape> shapes_around(const Lines& lines) {
  Random random{10};
  std::vector<Shape> shapes;
  for (const RoundCone& cone : cones_around(lines)) {
    const Segment& line = cone.axis;
    const Vec3 along = line.q - line.p;
    const float length = std::sqrt(dot(along, along));
    Box box = line.bounds();
    const std::size_t kind = random.below(4);
    if (kind == 0) shapes.push_back(shape_of(Shape::round_cone, cone));
    if (kind == 1)
      shapes.push_back(shape_of(Shape::triangle, Triangle{{line.p, line.q, line.p + random.direction() * length}}));
    if (kind == 3) box.hi[random.below(3)] += 0.1f * length;
    if (kind >= 2) shapes.push_back(shape_of(Shape::box, box));
  }
  return shapes;
}

/// Layers of lines behind one another, the last one first. Gaps are wider than a quantum.
Lines layers() {
  Lines lines;
  for (int i = 600; i > 0; --i) {
    const float z = 0.02f * float(i / 20) + 1e-4f * float(i % 20);
    lines.push_back({{0, 0.5f, z}, {1, 0.5f, z}});
  }
  return lines;
}

void check_scans() {
  Random random{7};
  for (const std::size_t n : {1, 2, 255, 256, 257, 70000}) {
    std::vector<std::int64_t> numbers(n), sums(n);
    for (auto& number : numbers) number = std::int64_t(random.below(1000));
    std::partial_sum(numbers.begin(), numbers.end(), sums.begin());
    scan(numbers);
    check(numbers == sums, "scans give the sums of all numbers up to each");
  }
}

}  // namespace

int main() {
  return run([] {
    check_scans();
    check_chains();
    std::vector<Scene> all = scenes();
    all.push_back({"layers", layers()});
    for (const auto& [name, lines] : all) {
      const Segments segments{lines};
      check_scene<DeviceSegments>(name, lines, segments, segments);
      if (kEmulatesWarps) continue;  // the other programs run the other exact tests faster
      const std::vector<RoundCone> cones = cones_around(lines);
      const RoundCones round_cones{cones};
      check_scene<DeviceRoundCones>(name, lines, round_cones, round_cones);
      check_scene<DeviceSpreadCones>(name, lines, round_cones, SpreadCones{cones});
      const std::vector<Shape> shapes = shapes_around(lines);
      check_scene<DeviceShapes>(name, lines, Shapes{shapes}, Shapes{shapes});
    }
    check(kEmulatesWarps || n_repeated > 3, "some shapes are in several leaves");
    check(n_differ == 0, "all answers are those of brute force");
    std::printf("%zu answers, %zu decisions of brute force\n", n_answers, n_decisions);
  });
}
