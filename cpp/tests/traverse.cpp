// Traversals of one ray by a function: all kinds of primitives, limits, traversals within others, and exceptions.
#include <memory>

#include "check.hpp"
#include "fastlines/primitives/spread_cones.hpp"
#include "scenes.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// A tree over primitives. `built` has the same primitives as `prims`, as builders see them.
template <class P>
struct Traversed {
  Progress progress;
  P prims;
  WideBvh wide;
  WideBvhView<P> view;
  BruteForce<P> brute;

  template <class Built>
  Traversed(const Built& built, const P& prims_)
      : prims(prims_), wide(layout_of(built)), view(view_of(wide, prims)), brute{prims, view.frame} {}

  template <class Built>
  WideBvh layout_of(const Built& built) {
    Settings settings;
    settings.splits = {{PlaneGrid{4}}};
    settings.limits.max_leaf_refs = 8;
    settings.lanes = 16;
    const Tree tree = Builder(built, settings, progress).build();
    return collapse(tree.nodes, tree.refs, built, {}, 1, progress);
  }
};

RayQuery some_query(Random& random, float spread) {
  return {random.in_cube() * 1.5f, random.direction() * 2.0f, 0.0f, kInfinity, 0.05f * random.uniform(), spread};
}

/// All hits of a ray: by t, id and distance, each primitive once.
template <class P>
std::vector<Hit> traverse_all(const WideBvhView<P>& tree, const RayOf<P>& ray, At at) {
  std::vector<Hit> hits;
  const auto visit = [&](const ClosestApproach<float>& hit, const Reference& piece, float&) {
    if (AxisPrimitive<P> && !owns(piece.s0, piece.s1, hit.s)) return;
    for (const Hit& other : hits)
      if (other.prim == std::int64_t(piece.prim)) return;
    hits.push_back({ray.t_ray(hit.t), piece.prim, hit.s, ray.distance(hit.dist2)});
  };
  traverse(tree, ray, visit, at);
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return comes_first(Keep::all, a, b); });
  return hits;
}

template <class P>
bool is_brute_force(const Traversed<P>& of, const RayOf<P>& ray, At at, const std::vector<Hit>& got) {
  std::vector<Hit> hits;
  typename BruteForce<P>::Scratch scratch;
  HitVectorOfRay<Hit> list(ray, at, Keep::all, hits);
  of.brute(ray, list, scratch);
  list.finish();
  return std::ranges::equal(hits, got, [](const Hit& a, const Hit& b) {
    return a.t == b.t && a.prim == b.prim && a.u == b.u && a.distance == b.distance;
  });
}

/// Returns the number of hits.
template <class P>
std::size_t check_all_hits(const Traversed<P>& of, float spread) {
  Random random{5};
  std::size_t n_hits = 0;
  for (int i = 0; i < 200; ++i) {
    const auto ray = prepare_for<P>(some_query(random, spread), of.view.frame);
    for (const At at : {At::closest, At::surface}) {
      if (kHasSpread<P> && at == At::surface) continue;
      const std::vector<Hit> got = traverse_all(of.view, ray, at);
      check(is_brute_force(of, ray, at, got), "a traversal reports all hits");
      n_hits += got.size();
    }
  }
  return n_hits;
}

void check_limits(const Traversed<Segments>& of) {
  Random random{6};
  for (int i = 0; i < 200; ++i) {
    const Ray ray = prepare(some_query(random, 0.0f), of.view.frame);
    const std::size_t n_hits = traverse_all(of.view, ray, At::closest).size();
    // Nothing is reported beyond the limit, or once no more hits are needed.
    int n = 0;
    float last = kInfinity;
    traverse(of.view, ray, [&](const ClosestApproach<float>& hit, const Reference&, float& limit) {
      check(hit.t <= last, "no hit is beyond the limit");
      last = limit = hit.t;
      ++n;
    });
    check((n > 0) == (n_hits > 0), "the first hit is reported");
    n = 0;
    traverse(of.view, ray, [&](const ClosestApproach<float>&, const Reference&, float& limit) {
      limit = kNoMoreHits;
      ++n;
    });
    check(n == (n_hits > 0), "a traversal ends where no more hits are needed");
  }
}

/// A function may traverse another ray, or throw: then the next traversal is as any.
void check_within(const Traversed<Segments>& of) {
  Random random{7};
  for (int i = 0; i < 50; ++i) {
    const Ray ray = prepare(some_query(random, 0.0f), of.view.frame);
    const Ray other = prepare(some_query(random, 0.0f), of.view.frame);
    const std::vector<Hit> of_other = traverse_all(of.view, other, At::closest);
    std::size_t n = 0, n_wrong = 0;
    traverse(of.view, ray, [&](const ClosestApproach<float>& hit, const Reference& piece, float&) {
      n += owns(piece.s0, piece.s1, hit.s);
      n_wrong += !is_brute_force(of, other, At::closest, traverse_all(of.view, other, At::closest));
    });
    check(n == traverse_all(of.view, ray, At::closest).size() && n_wrong == 0, "a traversal within another one");
    bool thrown = false;
    try {
      traverse(of.view, ray, [](const ClosestApproach<float>&, const Reference&, float&) { throw 1; });
    } catch (int) {
      thrown = true;
    }
    check(thrown == (n > 0), "what a function throws reaches the caller");
    check(is_brute_force(of, other, At::closest, traverse_all(of.view, other, At::closest)), "a traversal after that");
  }
}

}  // namespace

int main() {
  return test::run([] {
    const test::Lines lines = test::hair(100);
    Random random{8};
    std::vector<RoundCone> cones;
    std::vector<Shape> shapes;
    for (const Segment& line : lines) {
      cones.push_back({line, 0.02f * random.uniform(), 0.02f * random.uniform()});
      shapes.push_back(cones.size() % 2 ? shape_of(Shape::round_cone, cones.back())
                                        : shape_of(Shape::box, line.bounds()));
    }
    const Traversed<Segments> segments(Segments{lines}, Segments{lines});
    check(check_all_hits(segments, 0.0f) > 100, "rays hit segments");
    check(check_all_hits(Traversed<SpreadCones>(RoundCones{cones}, SpreadCones{cones}), 0.01f) > 100, "rays hit cones");
    check(check_all_hits(Traversed<Shapes>(Shapes{shapes}, Shapes{shapes}), 0.0f) > 100, "rays hit shapes");
    check_limits(segments);
    check_within(segments);
  });
}
