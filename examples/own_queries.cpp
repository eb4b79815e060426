// Queries of your own: a function that the traversal calls for each hit of a ray, or for each line near a point. Brute
// force gives the same answers.
//
//     g++ -std=c++20 -O2 -mavx2 -mfma -mbmi -mbmi2 -ffp-contract=off -pthread -I cpp examples/own_queries.cpp &&
//     ./a.out
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "fastlines/core.hpp"

using namespace fastlines;

namespace {

using LineTree = WideBvhView<Segments>;

/// The least distance of a ray from a line within its radius; infinite if there is none.
float least_distance(const LineTree& tree, const Ray& ray) {
  float least2 = kInfinity;
  traverse(tree, ray,
           [&](const ClosestApproach<float>& hit, const Reference&, float&) { least2 = std::min(least2, hit.dist2); });
  return ray.distance(least2);
}

/// Whether a ray hits at least n lines. A line in several leaves counts once: for the piece that owns the hit.
bool hits_at_least(const LineTree& tree, const Ray& ray, int n) {
  traverse(tree, ray, [&](const ClosestApproach<float>& hit, const Reference& piece, float& limit) {
    if (owns(piece.s0, piece.s1, hit.s) && --n == 0) limit = kNoMoreHits;
  });
  return n <= 0;
}

/// The first hit of a ray on a line that is not hidden.
Hit first_visible(const LineTree& tree, const Ray& ray, const std::vector<bool>& is_hidden) {
  FirstHitOfRay<ChosenAt> first(ray, {At::surface});
  const auto visit = [&](const ClosestApproach<float>& hit, const Reference& piece, float& limit) {
    if (is_hidden[piece.prim]) return;
    first.add(hit, piece);
    limit = first.limit;
  };
  traverse(tree, ray, visit, first.at);
  return first.hit();
}

/// The number of visible lines within a radius of a point.
std::size_t count_visible(const LineTree& tree, const double* at, float radius, const std::vector<bool>& is_hidden) {
  std::size_t n = 0;
  const PointQuery point = prepare_point(at, radius, /*surface=*/false, tree.frame);
  traverse_near(tree, point, [&](const Neighbour& found, const Reference& piece, float&) {
    n += owns(piece.s0, piece.s1, found.s) && !is_hidden[piece.prim];
  });
  return n;
}

/// The same by brute force.
std::size_t count_all(const Segments& prims, const LineTree& tree, const double* at, float radius,
                      const std::vector<bool>& is_hidden) {
  const PointQuery point = prepare_point(at, radius, /*surface=*/false, tree.frame);
  std::size_t n = 0;
  for (std::uint32_t i = 0; i < prims.size(); ++i)
    n += !is_hidden[i] && nearest_point<Segments>(point, point_fields_of<Segments>(prims.item(i), tree.frame)).within;
  return n;
}

/// Short lines in a cube.
std::vector<Segment> some_lines(std::mt19937& random, int n) {
  const auto uniform = [&](float low, float high) { return low + (high - low) * float(random() / 4294967296.0); };
  std::vector<Segment> lines;
  while (int(lines.size()) < n) {
    const Vec3 p{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    lines.push_back({p, p + Vec3{uniform(-0.1f, 0.1f), uniform(-0.1f, 0.1f), uniform(-0.1f, 0.1f)}});
  }
  return lines;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  const std::vector<Segment> lines = some_lines(random, 20'000);
  std::vector<bool> is_hidden;
  for (std::size_t i = 0; i < lines.size(); ++i) is_hidden.push_back(random() % 2 == 0);
  const Segments prims{lines};
  Progress progress;
  Settings settings;
  settings.limits.max_leaf_refs = 16;
  const Tree tree = Builder(prims, settings, progress).build();
  const WideBvh wide = collapse(tree.nodes, tree.refs, prims, {}, /*n_threads=*/1, progress);
  const LineTree view = view_of(wide, prims);
  const BruteForce<Segments> brute{prims, view.frame};

  constexpr int side = 32;
  int n_equal = 0, n_hit = 0;
  for (int i = 0; i < side * side; ++i) {
    const Vec3 direction{float(i % side) / side - 0.5f, 0.5f - float(i / side) / side, -1.0f};
    const Ray ray = prepare({{0, 0, 3}, direction, 0.0f, kInfinity, /*radius=*/0.01f}, view.frame);
    // All hits by brute force, at the closest approach and at the surface.
    BruteForce<Segments>::Scratch scratch;
    std::vector<Hit> all, at_surface;
    HitVectorOfRay<Hit> list(ray, At::closest, Keep::all, all), second(ray, At::surface, Keep::all, at_surface);
    brute(ray, list, scratch);
    brute(ray, second, scratch);
    second.finish();
    float least = kInfinity;
    for (const Hit& hit : all) least = std::min(least, hit.distance);
    Hit visible;
    for (auto hit = at_surface.rbegin(); hit != at_surface.rend(); ++hit)
      if (!is_hidden[std::size_t(hit->prim)]) visible = *hit;

    const double point[] = {direction[0], direction[1], 0.0};
    const Hit found = first_visible(view, ray, is_hidden);
    n_equal += least_distance(view, ray) == least && hits_at_least(view, ray, 3) == (all.size() >= 3) &&
               found.prim == visible.prim && found.t == visible.t &&
               count_visible(view, point, 0.1f, is_hidden) == count_all(prims, view, point, 0.1f, is_hidden);
    n_hit += found.prim >= 0;
  }
  std::printf("%d of %d rays hit a visible line, and the answers of %d are those of brute force\n", n_hit, side * side,
              n_equal);
  return n_equal == side * side && n_hit > 0 ? 0 : 1;
}
