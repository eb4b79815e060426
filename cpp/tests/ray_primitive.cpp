// Traces a primitive that the library does not know on the fast path: the tubes of docs/extending.md, each with its own
// radius. Every kernel gives the answers of brute force, bit for bit; the answers for balls are known in closed form.
#include <cmath>
#include <cstring>

#include "check.hpp"
#include "scenes.hpp"
#include "tubes.hpp"

using namespace fastlines;
using test::check, test::Random, test::Scene;

namespace {

constexpr Kernel kKernels[] = {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle};

struct Found {
  std::vector<float> t, u, distance, t_out;
  std::vector<std::int64_t> prim, count;
  std::vector<Hit> all;  // one ray after the other

  explicit Found(std::size_t n) : t(n), u(n), distance(n), t_out(n), prim(n), count(n) {}
  bool operator==(const Found& other) const {
    return std::memcmp(t.data(), other.t.data(), t.size() * sizeof(float)) == 0 && prim == other.prim &&
           std::memcmp(u.data(), other.u.data(), u.size() * sizeof(float)) == 0 &&
           std::memcmp(distance.data(), other.distance.data(), distance.size() * sizeof(float)) == 0 &&
           count == other.count && t_out == other.t_out && all.size() == other.all.size() &&
           std::ranges::equal(all, other.all, [](const Hit& a, const Hit& b) {
             return a.t == b.t && a.prim == b.prim && a.u == b.u && a.distance == b.distance && a.t_out == b.t_out;
           });
  }
  HitColumns columns() { return {t.data(), prim.data(), u.data(), distance.data(), t_out.data()}; }
  void add(HitAssembler& lists) {
    const auto offsets = lists.offsets();
    for (std::size_t i = 0; i < std::size_t(offsets.back()); ++i)
      all.push_back({lists.t[i], lists.prim[i], lists.u[i], lists.distance[i], lists.t_out[i]});
  }
};

/// The definition, at the surface.
template <class Search>
Found search_all(const Search& search, const RayBatch& rays, At at, Progress& progress) {
  Found found(rays.size());
  first_hits(search, rays, at, 1, progress, [&](std::size_t i, const Hit& hit) { found.columns().set(i, hit); });
  count_hits(search, rays, at, 1, progress, found.count);
  HitAssembler lists(rays.size(), true);
  list_hits(search, rays, 1, progress, lists, at);
  found.add(lists);
  return found;
}

Found run_kernel(const WideBvhView<Tubes>& view, const RayBatch& rays, Kernel kernel, At at, Progress& progress) {
  Found found(rays.size());
  run_batch(view, rays, kernel, FirstHitQuery<Tubes, SurfaceAt>{view, found.columns(), SurfaceAt(at)}, 1, progress);
  if (at == At::entry)
    run_batch(view, rays, kernel, CountEntriesQuery{found.count.data()}, 1, progress);
  else
    run_batch(view, rays, kernel, CountHitsQuery{found.count.data()}, 1, progress);
  HitAssembler lists(rays.size(), true);
  run_lists(view, rays, kernel, AllHitsQuery<Tubes>(view, at), 1, progress, lists);
  found.add(lists);
  return found;
}

std::vector<Tube> tubes_around(const test::Lines& lines, Random& random) {
  std::vector<Tube> tubes;
  for (const Segment& line : lines) {
    const float share = random.uniform();
    tubes.push_back({line, 0.05f * share * share * share});
  }
  return tubes;
}

/// Returns how many hits there are.
std::size_t check_scene(const Scene& scene, Random& random) {
  std::size_t n_hits = 0;
  const std::vector<Tube> tubes = tubes_around(scene.lines, random);
  const Tubes prims{tubes};
  Progress progress;
  Settings settings;
  settings.splits = {{BinnedPlanes{.n_planes = 8, .uncut_refs = 64}}};
  settings.bad_levels = 2;
  settings.lanes = 16;
  settings.limits = {.max_leaf_refs = 16, .max_refs = 8 * tubes.size() + 100};
  const Tree tree = Builder(prims, settings, progress).build();
  const WideBvh wide = collapse(tree.nodes, tree.refs, prims, {}, 1, progress);
  const WideBvhView<Tubes> view = view_of(wide, prims);
  const BruteForce<Tubes> brute{prims, view.frame};
  const BinaryTraversal<Tubes> binary{tree.nodes, tree.refs, prims, view.frame};

  for (const bool coherent : {true, false}) {
    std::vector<Vec3> origins, directions;
    for (int i = 0; i < 512; ++i) {
      origins.push_back(coherent ? Vec3{0.5f, 0.5f, -2.0f} : random.in_cube() * 2.0f);
      directions.push_back(coherent ? Vec3{float(i % 32) / 32 - 0.5f, float(i / 32) / 16 - 0.5f, 2.5f}
                                    : random.direction());
    }
    for (const float radius : {0.0f, 0.01f}) {
      const float t_min = 0.0f, t_max = kInfinity;
      const RayBatch rays{origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}};
      for (const At at : {At::surface, At::entry}) {
        const Found expected = search_all(brute, rays, at, progress);
        n_hits += expected.all.size();
        check(search_all(binary, rays, at, progress) == expected, "the binary tree answers as brute force does");
        for (const Kernel kernel : kKernels)
          check(run_kernel(view, rays, kernel, at, progress) == expected, "a kernel answers as brute force does");
      }
    }
  }
  return n_hits;
}

/// Presplit, reinsertion and refits make valid trees over pieces of the axes.
void check_trees_over_pieces(const Scene& scene, Random& random) {
  std::vector<Tube> tubes = tubes_around(scene.lines, random);
  Progress progress;
  Settings settings;
  settings.splits = {{PlaneGrid{4}}};
  settings.presplit = {.area = 0.0, .max_refs = 3 * tubes.size()};
  settings.limits = {.max_leaf_refs = 4, .max_refs = 8 * tubes.size() + 100};
  const Tree built = Builder(Tubes{tubes}, settings, progress).build();
  const Tree moved = Reinsertion(built.nodes, built.refs, {3, kMaxDepth, 0.0, 1}, progress)();
  for (const Tree& tree : {built, moved}) {
    check(!validate_pieces(Tubes{tubes}, tree.nodes, tree.refs, BoxRule::tight), "a tree over pieces is valid");
    if (tree.nodes.size() > 2) {
      auto broken = tree.nodes;
      broken[1].box.hi[0] += broken[0].box.side(0) * 0.1f + 0.1f;
      check(bool(validate_pieces(Tubes{tubes}, broken, tree.refs, BoxRule::tight)), "a loose box is found");
    }
  }
  for (Tube& tube : tubes) std::swap(tube.axis.p[0], tube.axis.q[1]);
  std::vector<Node> fitted(moved.nodes.size());
  Refit(moved.nodes, moved.refs, Tubes{tubes}, fitted.data())(1, progress);
  check(!validate_pieces(Tubes{tubes}, fitted, moved.refs, BoxRule::tight), "a refitted tree is valid");
}

/// A tube of length zero is a ball: a ray through its centre enters and leaves at ± its radius.
void check_balls() {
  const Tube ball{{{1, 2, 3}, {1, 2, 3}}, 0.25f};
  const BruteForce<Tubes> search{Tubes{{&ball, 1}}, frame_of(Box{{0, 0, 0}, {4, 4, 4}})};
  const Ray ray = prepare({{1, 2, -1}, {0, 0, 2}, 0.0f, 100.0f, 0.0f}, search.frame);
  FirstHitOfRay<ChosenAt> first(ray, {At::surface});
  BruteForce<Tubes>::Scratch scratch;
  search(ray, first, scratch);
  check(std::abs(first.hit().t - 1.875f) < 1e-5f, "a ball is hit");
  check(std::abs(exit_of(search, ray, 0) - 2.125f) < 1e-5f, "a ray leaves a ball");
  check(first.hit().distance < 1e-6f, "the distance is that of the axis");
}

}  // namespace

int main() {
  return test::run([] {
    Random random{77};
    std::size_t n_hits = 0;
    for (const Scene& scene : test::scenes()) n_hits += check_scene(scene, random);
    for (const Scene& scene : test::scenes()) check_trees_over_pieces(scene, random);
    check(n_hits > 10'000, "rays hit tubes");
    check_balls();
  });
}
