// Culls the pieces near points with just their distance as the limit, by the exact test. No box above a piece that owns
// the nearest place may be culled, and neither may the piece: for one point, and for groups of 16. Points lie from a
// millionth of the scene's size up to a million sizes away; pieces are cut, long, short, thick, in tiny clusters, and
// far from zero. A sixteenth of the eps that covers rounding would lose some.
#include <cmath>
#include <random>

#include "check.hpp"
#include "fastlines/core.hpp"
#include "fastlines/kernels/proximity/point_group.hpp"

namespace {

using namespace fastlines;
using test::check;

std::mt19937 random_bits(59);

double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_bits); }
double power_of_ten(double from, double to) { return std::pow(10.0, uniform(from, to)); }

Vec3 direction() {
  Vec3 d{float(uniform(-1, 1)), float(uniform(-1, 1)), float(uniform(-1, 1))};
  if (random_bits() % 4 == 0) d[random_bits() % 3] = 0.0f;
  return d * float(1.0 / std::sqrt(std::max(1e-6f, dot(d, d))));
}

/// A place, and how large things there are; the scene is from −1 to 1 around `middle`.
struct Cluster {
  Vec3 at;
  float size;
};

struct Scene {
  Vec3 middle;
  std::vector<Cluster> clusters;

  Scene() {
    const double away = random_bits() % 2 ? 0.0 : power_of_ten(0, 5);
    middle = direction() * float(away);
    for (int i = 0; i < 4; ++i) clusters.push_back({middle + direction(), float(power_of_ten(-5, 0))});
    clusters.push_back({middle, 1.0f});
  }

  Segment axis() const {
    const Cluster& in = clusters[random_bits() % clusters.size()];
    const Vec3 p = in.at + direction() * (in.size * float(uniform(0, 1)));
    return {p, random_bits() % 8 ? p + direction() * float(in.size * power_of_ten(-3, 0.2)) : p};
  }

  float radius() const {
    return random_bits() % 6 ? float(clusters[random_bits() % clusters.size()].size * power_of_ten(-3, 0)) : 0.0f;
  }

  RoundCone cone() const {
    const float r = radius();
    return {axis(), r, random_bits() % 2 ? r : r * float(uniform(0, 1))};
  }

  Shape shape() const {
    const Segment one = axis();
    if (random_bits() % 3 == 0) return shape_of(Shape::round_cone, cone());
    if (random_bits() % 2) return shape_of(Shape::box, one.bounds());
    return shape_of(Shape::triangle, Triangle{{one.p, one.q, one.p + direction() * radius()}});
  }
};

/// A wide layout whose primitives are cut often.
template <class P>
struct Layout {
  Progress progress;
  P prims;
  WideBvh wide;
  WideBvhView<P> view;

  Layout(const P& prims_, BoxRule boxes) : prims(prims_), wide(made(boxes)), view(view_of(wide, prims)) {}

  WideBvh made(BoxRule boxes) {
    Settings settings;
    settings.splits = {{PlaneGrid{5}}};
    settings.boxes = boxes;
    settings.cost = {0.05, 1.0};
    settings.limits.max_leaf_refs = boxes == BoxRule::tight ? 6 : std::size_t(-1);
    settings.limits.max_refs = 20 * prims.size();
    settings.lanes = 16;
    const Tree tree = Builder(prims, settings, progress).build();
    return collapse(tree.nodes, tree.refs, prims, {}, 1, progress);
  }
};

/// What culling keeps and loses.
struct Counts {
  std::uint64_t n_kept = 0, n_lost = 0;
};

/// Counts what culling loses.
template <class P>
struct Attack {
  const Layout<P>& layout;
  Counts counts = {};
  std::vector<NearestPoint<float>> found = {};  // of each primitive
  std::vector<bool> kept = {};
  PointGroupSearch<P> group{layout.view};

  void operator()(const PointQuery& query) {
    const std::size_t n = layout.prims.size();
    found.clear();
    for (std::size_t i = 0; i < n; ++i)
      found.push_back(
          nearest_point<P>(query, point_fields_of<P>(layout.prims.item(std::uint32_t(i)), layout.view.frame)));
    kept.assign(n, false);
    std::vector<float> box_dist2;  // of all boxes above a leaf
    visit(query, 0, box_dist2);
    for (std::size_t first = 0; first < n; first += kSimdWidth)
      search_group(query, first, std::min(n - first, std::size_t(kSimdWidth)));
    for (std::size_t i = 0; i < n; ++i) ++(kept[i] ? counts.n_kept : counts.n_lost);
  }

  /// Search with the distances of n primitives as the radii of a group. The square of the radius does not matter.
  void search_group(const PointQuery& query, std::size_t first, std::size_t n) {
    Progress progress;
    Checkpoint checkpoint(progress);
    std::vector<PointQuery> points(n, query);
    for (std::size_t i = 0; i < n; ++i) points[i].radius = found[first + i].distance;
    const std::size_t ids[kSimdWidth] = {};
    std::uint32_t lengths[kSimdWidth];
    std::vector<Neighbour> lists;
    group.list(points, ids, Seen(), checkpoint, lists, lengths);
    auto at = lists.begin();
    for (std::size_t i = 0; i < n; at += lengths[i++])
      if (std::none_of(at, at + lengths[i], [&](const Neighbour& near) { return near.row == first + i; }))
        kept[first + i] = false;
  }

  void visit(const PointQuery& query, std::uint32_t index, std::vector<float>& above) {
    const WideNode& node = layout.view.nodes[index];
    FloatX16 all;
    float dist2[kSimdWidth];
    cull_boxes(query.p, node, node.planes, node.n_children, kInfinity, all);
    all.store(dist2);
    for (std::uint32_t child = 0; child < node.n_children; ++child) {
      above.push_back(dist2[child]);
      if (child < node.n_inner)
        visit(query, node.first_inner + child, above);
      else
        visit_leaf(query, layout.view.leaves[node.first_leaf + (child - node.n_inner)],
                   *std::max_element(above.begin(), above.end()));
      above.pop_back();
    }
  }

  void visit_leaf(const PointQuery& query, const WideLeaf& leaf, float box_dist2) {
    for (std::uint32_t i = 0; i < leaf.n_refs; ++i) {
      const Reference ref = layout.view.refs[leaf.first_ref + i];
      const NearestPoint<float>& of = found[ref.prim];
      if (AxisPrimitive<P> && !owns(ref.s0, ref.s1, of.s)) continue;
      const float reach = box_reach<P>(query, of.distance);
      if (box_dist2 <= reach * reach && cull_pieces<P>(query, leaf, of.distance) >> i & 1) kept[ref.prim] = true;
    }
  }
};

/// Attack trees over primitives. Returns what a smaller eps loses.
template <class P>
std::uint64_t attack(const P& prims, const Scene& scene, const char* what) {
  std::uint64_t n_lost = 0;
  for (const BoxRule boxes : {BoxRule::tight, BoxRule::cut}) {
    const Layout<P> layout(prims, boxes);
    Attack<P> attack{layout}, with_less{layout};
    for (int i = 0; i < 100; ++i) {
      const Segment near = scene.axis();
      const Vec3 at = near.p + (near.q - near.p) * float(uniform(0, 1)), away = direction();
      const double far = i % 10 ? power_of_ten(-6, 6) : 0.0;
      double point[3];
      for (int k = 0; k < 3; ++k) point[k] = double(at[k]) + far * away[k];
      for (const bool surface : {false, true}) {
        PointQuery query = prepare_point(point, kInfinity, surface, layout.view.frame);
        attack(query);
        query.eps = layout.view.frame.overhang + (query.eps - layout.view.frame.overhang) / 16;
        with_less(query);
      }
    }
    check(attack.counts.n_lost == 0, what);
    check(attack.counts.n_kept == 200 * prims.size(), "each primitive is kept for each point");
    n_lost += with_less.counts.n_lost;
  }
  return n_lost;
}

void cull() {
  std::uint64_t n_lost = 0;
  for (int i = 0; i < 12; ++i) {
    const Scene scene;
    std::vector<Segment> segments;
    std::vector<RoundCone> cones;
    std::vector<Shape> shapes;
    while (segments.size() < 60) {
      segments.push_back(scene.axis());
      cones.push_back(scene.cone());
      shapes.push_back(scene.shape());
    }
    n_lost += attack(Segments{segments}, scene, "no segment is lost");
    n_lost += attack(RoundCones(cones), scene, "no round cone is lost");
    n_lost += attack(Shapes{shapes}, scene, "no shape is lost");
  }
  check(n_lost > 100, "a sixteenth of eps loses some, so the points are tight");
}

}  // namespace

int main() { return test::run(cull); }
