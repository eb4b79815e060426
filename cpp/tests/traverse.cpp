// Traversals of one ray, or around one point, by a function: all kinds of primitives, larger frames, limits, traversals
// within others, and exceptions.
#include <memory>

#include "check.hpp"
#include "fastlines/layout/check_layout.hpp"
#include "fastlines/primitives/spread_cones.hpp"
#include "scenes.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// A tree over primitives, in the frame of a box that is larger by `margin` on one side, and three times as much on the
/// other. `built` has the same primitives as `prims`, as builders see them.
template <class P>
struct Traversed {
  Progress progress;
  P prims;
  WideBvh wide;
  WideBvhView<P> view;
  BruteForce<P> brute;

  template <class Built>
  Traversed(const Built& built, const P& prims_, float margin = 0.0f)
      : prims(prims_), wide(layout_of(built, margin)), view(view_of(wide, prims)), brute{prims, view.frame} {
    const auto fault = check_layout<P>({wide.nodes.data(), wide.nodes.size()}, {wide.leaves.data(), wide.leaves.size()},
                                       {wide.refs.data(), wide.refs.size()}, prims, progress);
    check(!fault, "a layout that was built is usable");
  }

  template <class Built>
  WideBvh layout_of(const Built& built, float margin) {
    Settings settings;
    settings.splits = {{PlaneGrid{4}}};
    settings.limits.max_leaf_refs = 8;
    settings.lanes = 16;
    const Tree tree = Builder(built, settings, progress).build();
    Box box = tree.nodes[0].box;
    for (int k = 0; k < 3; ++k) {
      box.lo[k] -= margin;
      box.hi[k] += 3 * margin;
    }
    return collapse(tree.nodes, tree.refs, built, {}, 1, progress, box);
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
    for (const At at : {At::closest, At::surface, At::entry}) {
      if (kHasSpread<P> && has_exit(at)) continue;
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

PointQuery some_point(Random& random, float radius, bool surface, const Frame& frame) {
  const Vec3 p = random.in_cube() * 1.5f;
  const double at[] = {p[0], p[1], p[2]};
  return prepare_point(at, radius, surface, frame);
}

/// What is near a point: by distance and id, each primitive once.
template <class P>
std::vector<Neighbour> traverse_all_near(const WideBvhView<P>& tree, const PointQuery& point) {
  std::vector<Neighbour> near;
  traverse_near(tree, point, [&](const Neighbour& found, const Reference& piece, float&) {
    if (AxisPrimitive<P> && !owns(piece.s0, piece.s1, found.s)) return;
    for (const Neighbour& other : near)
      if (other.row == found.row) return;
    near.push_back(found);
  });
  std::sort(near.begin(), near.end());
  return near;
}

/// Returns how many primitives are near points.
template <class P>
std::size_t check_near(const Traversed<P>& of, bool surface) {
  const auto is_same = [](const Neighbour& a, const Neighbour& b) {
    return a.distance == b.distance && a.row == b.row && a.s == b.s;
  };
  Random random{9};
  std::size_t n_near = 0;
  for (int i = 0; i < 200; ++i) {
    const PointQuery point = some_point(random, 0.2f * random.uniform(), surface, of.view.frame);
    std::vector<Neighbour> expected, found;
    const Seen seen;
    WithinOfPoint within(point, 0, seen, false, expected);
    Progress progress;
    Checkpoint checkpoint(progress);
    typename BruteForcePoints<P>::Scratch scratch;
    BruteForcePoints<P>{of.prims, of.view.frame}(point, within, scratch, checkpoint);
    within.finish();
    const OnePoint<P> one(of.view, point);
    check(std::ranges::equal(traverse_all_near(of.view, point), expected, is_same), "a traversal reports all");
    one.within(found);
    check(std::ranges::equal(found, expected, is_same), "one point has all primitives");
    check(one.count_within() == expected.size(), "one point counts them");
    check(is_same(one.nearest(), expected.empty() ? Neighbour() : expected[0]), "one point has the nearest");
    one.k_nearest(2, found);
    expected.resize(std::min<std::size_t>(2, expected.size()));
    check(std::ranges::equal(found, expected, is_same), "one point has the two nearest");
    n_near += expected.size();
  }
  return n_near;
}

/// A function about points may lower the limit, traverse around another point, or throw.
void check_near_limits(const Traversed<Segments>& of) {
  Random random{10};
  for (int i = 0; i < 100; ++i) {
    const PointQuery point = some_point(random, 0.2f, false, of.view.frame);
    const PointQuery other = some_point(random, 0.2f, false, of.view.frame);
    const std::size_t n_near = traverse_all_near(of.view, point).size(),
                      n_other = traverse_all_near(of.view, other).size();
    float last = kInfinity;
    std::size_t n = 0, n_wrong = 0;
    traverse_near(of.view, point, [&](const Neighbour& found, const Reference&, float& limit) {
      check(found.distance <= last, "nothing is beyond the limit");
      last = limit = found.distance;
      n_wrong += traverse_all_near(of.view, other).size() != n_other;
    });
    check((last < kInfinity) == (n_near > 0) && n_wrong == 0, "a traversal within another one");
    traverse_near(of.view, point, [&](const Neighbour&, const Reference&, float& limit) {
      limit = -kInfinity;
      ++n;
    });
    check(n == (n_near > 0), "nothing is reported once nothing is needed");
    bool thrown = false;
    try {
      traverse_near(of.view, point, [](const Neighbour&, const Reference&, float&) { throw 1; });
    } catch (int) {
      thrown = true;
    }
    check(thrown == (n_near > 0) && traverse_all_near(of.view, other).size() == n_other, "what is thrown is passed on");
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
    for (const float margin : {0.01f, 1.0f, 100.0f}) {
      check(check_all_hits(Traversed<Segments>(Segments{lines}, Segments{lines}, margin), 0.0f) > 100, "in a frame");
      const Traversed<RoundCones> larger(RoundCones{cones}, RoundCones{cones}, margin);
      check(check_all_hits(larger, 0.0f) > 100 && check_near(larger, true) > 100, "round cones in a frame");
      check(check_all_hits(Traversed<Shapes>(Shapes{shapes}, Shapes{shapes}, margin), 0.0f) > 100, "shapes in a frame");
    }
    const Traversed<RoundCones> thick(RoundCones{cones}, RoundCones{cones});
    check(check_near(segments, false) > 100, "segments are near points");
    check(check_near(thick, true) > 100 && check_near(thick, false) > 100, "round cones are near points");
    check(check_near(Traversed<Shapes>(Shapes{shapes}, Shapes{shapes}), true) > 100, "shapes are near points");
    check_near_limits(segments);
    check_limits(segments);
    check_within(segments);
  });
}
