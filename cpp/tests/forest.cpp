// Forests: the top tree finds every tile in which a ray has hits, or in which something is near a point; and rays that
// go from tile to tile find what brute force finds among all lines.
#include <algorithm>
#include <array>

#include "check.hpp"
#include "fastlines/forest/list_merge.hpp"
#include "fastlines/query/proximity/brute_force_points.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

/// Lines in tiles: every n-th, or runs of neighbours along x.
struct Forest {
  Lines lines;
  Box box = Box::empty();
  std::vector<Lines> tiles;
  std::vector<std::vector<std::int64_t>> ids;
  std::vector<TileBox> boxes;

  Forest(const Lines& lines_, std::size_t n_tiles, bool scattered) : lines(lines_), tiles(n_tiles), ids(n_tiles) {
    std::vector<std::size_t> rank(lines.size());
    std::vector<std::size_t> order(lines.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return lines[a].p[0] < lines[b].p[0]; });
    for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::size_t tile = scattered ? i % n_tiles : rank[i] * n_tiles / lines.size();
      tiles[tile].push_back(lines[i]);
      ids[tile].push_back(std::int64_t(i));
    }
    for (const Lines& tile : tiles) {
      boxes.push_back({bounds_of_all(Segments{tile}), 0.0f});
      box.grow(boxes.back().box);
    }
  }

  Frame frame() const { return frame_of(box); }
  TopTree top() const { return {boxes, box}; }
  BruteForce<Segments> whole() const { return {Segments{lines}, frame()}; }
  BruteForce<Segments> of_tile(std::size_t tile) const { return {Segments{tiles[tile]}, frame()}; }
};

/// Rays by their numbers.
Rays some(const RayBatch& rays, std::span<const std::uint32_t> of, std::vector<float>& limits) {
  Rays made{.name = "some", .origins = {}, .directions = {}, .radius = {}, .t_min = {}, .t_max = {}, .spread = {}};
  for (const std::uint32_t i : of) {
    const RayQuery ray = rays[i];
    made.origins.push_back(ray.origin);
    made.directions.push_back(ray.direction);
    made.radius.push_back(ray.radius);
    made.t_min.push_back(ray.t_min);
    made.t_max.push_back(ray.t_max);
    made.spread.push_back(ray.spread);
    limits.push_back(kInfinity);
  }
  return made;
}

void check_routes(const Forest& forest, const RayBatch& rays, At at, Progress& progress) {
  const TopTree top = forest.top();
  const RayRoutes routes = routes_of(top, rays, 2, progress);
  for (std::size_t tile = 0; tile < forest.tiles.size(); ++tile) {
    HitAssembler lists(rays.size(), true);
    list_hits(forest.of_tile(tile), rays, 1, progress, lists, at);
    const auto offsets = lists.offsets();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::span<const RouteStep> route = routes.of(i);
      check(std::is_sorted(route.begin(), route.end(), [](auto& a, auto& b) { return a.enter < b.enter; }),
            "routes are sorted");
      if (offsets[i] == offsets[i + 1]) continue;
      const auto step = std::find_if(route.begin(), route.end(), [&](const RouteStep& s) { return s.tile == tile; });
      check(step != route.end(), "a tile with hits is on the route");
      if (step != route.end()) check(step->enter <= lists.t[std::size_t(offsets[i])], "no hit is before the tile");
    }
  }
}

void check_first_hits(const Forest& forest, const RayBatch& rays, At at, Progress& progress) {
  const TopTree top = forest.top();
  TileWalk walk(routes_of(top, rays, 2, progress), rays, 2);
  Hits best(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) best.columns().set(i, Hit{});
  std::vector<std::uint8_t> is_open(top.n_tiles());
  for (std::int64_t tile; (tile = walk.next_tile(is_open)) >= 0;) {
    const auto number = std::size_t(tile);
    is_open[number] = 1;
    const TileWalk::Rows taken = walk.take(number);
    std::vector<float> limits;
    const Rays some_rays = some(rays, taken, limits);
    for (std::size_t j = 0; j < taken.size(); ++j) limits[j] = best.t[taken[j]];
    RayBatch batch = some_rays.batch();
    batch.limit = limits;
    Hits found(taken.size());
    first_hits(forest.of_tile(number), batch, at, 1, progress,
               [&](std::size_t j, const Hit& hit) { found.columns().set(j, hit); });
    walk.advance(taken, [&](std::size_t j, std::uint32_t ray) {
      return keep_first(best.columns(), ray, found.columns(), j, {forest.ids[number]});
    });
  }
  first_hits(forest.whole(), rays, at, 1, progress, [&](std::size_t i, const Hit& hit) {
    check(best.prim[i] == hit.prim && best.t[i] == hit.t && best.u[i] == hit.u && best.t_out[i] == hit.t_out &&
              best.distance[i] == hit.distance,
          "first hits from tile to tile are those of brute force");
  });
}

void check_lists(const Forest& forest, const RayBatch& rays, At at, Keep keep, std::uint64_t k, Progress& progress) {
  const TopTree top = forest.top();
  const TileRays visits(routes_of(top, rays, 2, progress), rays);
  std::vector<HitAssembler*> found(top.n_tiles());
  std::vector<LargeVector<std::int64_t>> offsets(top.n_tiles());
  std::vector<std::vector<std::int64_t>> global(top.n_tiles());
  std::vector<TileLists> lists(top.n_tiles());
  std::vector<std::unique_ptr<HitAssembler>> kept;
  for (std::size_t tile = 0; tile < top.n_tiles(); ++tile) {
    std::vector<float> limits;
    const Rays some_rays = some(rays, visits.of_tile(tile), limits);
    HitAssembler& to = *kept.emplace_back(std::make_unique<HitAssembler>(limits.size(), true));
    if (limits.empty()) continue;
    list_hits(forest.of_tile(tile), some_rays.batch(), 1, progress, to, at, keep, k);
    offsets[tile] = to.offsets();
    const GlobalIds ids{forest.ids[tile]};
    for (std::int64_t i = 0; i < offsets[tile].back(); ++i) global[tile].push_back(ids(to.prim.data()[i]));
    lists[tile] = {offsets[tile], {to.t.data(), global[tile].data(), to.u.data(), to.distance.data(), to.t_out.data()}};
  }
  const ListMerge merge(visits, lists, keep, k);
  const auto merged_offsets = merge.offsets(2);
  Hits merged(std::size_t(merged_offsets.back()));
  merge.write(merged_offsets, merged.columns(), 2, progress);
  HitAssembler expected(rays.size(), true);
  list_hits(forest.whole(), rays, 1, progress, expected, at, keep, k);
  const auto expected_offsets = expected.offsets();
  bool same = std::ranges::equal(merged_offsets, expected_offsets);
  for (std::size_t i = 0; same && i < merged.t.size(); ++i)
    same = merged.t[i] == expected.t[i] && merged.prim[i] == expected.prim[i] && merged.u[i] == expected.u[i] &&
           merged.distance[i] == expected.distance[i] && merged.t_out[i] == expected.t_out[i];
  check(same, "merged lists are those of brute force");

  // The first k, from tile to tile.
  if (keep != Keep::first || k > 100) return;
  NextHits next(rays.size(), std::size_t(k));
  for (std::size_t tile = 0; tile < top.n_tiles(); ++tile) {
    HitColumns of_tile = lists[tile].hits;
    of_tile.prim = kept[tile]->prim.data();
    for (std::size_t j = 0; j < visits.of_tile(tile).size(); ++j)
      next.add(visits.of_tile(tile)[j], of_tile, std::size_t(offsets[tile][j]), std::size_t(offsets[tile][j + 1]),
               {forest.ids[tile]});
  }
  same = true;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::span<const Hit> hits = next.of(i);
    same &= std::int64_t(hits.size()) == merged_offsets[i + 1] - merged_offsets[i];
    for (std::size_t j = 0; same && j < hits.size(); ++j) {
      const std::size_t at_ = std::size_t(merged_offsets[i]) + j;
      same = hits[j].t == merged.t[at_] && hits[j].prim == merged.prim[at_] && hits[j].t_out == merged.t_out[at_];
    }
  }
  check(same, "the next hits that are kept are those of brute force");
}

/// The distance of a point from a tile is no more than from any of its lines.
void check_points(const Forest& forest) {
  const TopTree top = forest.top();
  Random random{9};
  for (int i = 0; i < 10; ++i) {
    double p[3];
    for (int k = 0; k < 3; ++k)
      p[k] = double(forest.box.lo[k]) + 1.5 * forest.box.side(forest.box.longest_axis()) * (random.uniform() - 0.25);
    std::vector<double> distance(top.n_tiles(), kInfinity);
    top.for_each_near(
        p, p, false, [] { return kInfinity; }, [&](std::uint32_t tile, double at) { distance[tile] = at; });
    for (std::size_t tile = 0; tile < top.n_tiles(); ++tile)
      for (const Segment& line : forest.tiles[tile]) {
        double dot = 0.0, length2 = 0.0, dist2 = 0.0;
        for (int k = 0; k < 3; ++k) {
          dot += (p[k] - line.p[k]) * (double(line.q[k]) - line.p[k]);
          length2 += (double(line.q[k]) - line.p[k]) * (double(line.q[k]) - line.p[k]);
        }
        const double s = length2 > 0.0 ? std::clamp(dot / length2, 0.0, 1.0) : 0.0;
        for (int k = 0; k < 3; ++k) {
          const double d = p[k] - line.p[k] - s * (double(line.q[k]) - line.p[k]);
          dist2 += d * d;
        }
        check(distance[tile] <= std::sqrt(dist2), "a tile is no farther than its lines");
      }
  }
}

}  // namespace

int main() {
  return run([] {
    Progress progress;
    for (const Scene& scene : scenes())
      for (const std::size_t n_tiles : {1, 3, 7, 20}) {
        if (scene.lines.size() < n_tiles) continue;
        for (const bool scattered : {false, true}) {
          const Forest forest(scene.lines, n_tiles, scattered);
          check_points(forest);
          for (const Rays& rays : rays_of(scene.lines, forest.box)) {
            const RayBatch batch = rays.batch();
            for (const At at : {At::closest, At::surface, At::entry}) {
              check_routes(forest, batch, at, progress);
              check_first_hits(forest, batch, at, progress);
            }
            check_lists(forest, batch, At::surface, Keep::first, ~0ull, progress);
            check_lists(forest, batch, At::entry, Keep::first, ~0ull, progress);
            check_lists(forest, batch, At::closest, Keep::first, 3, progress);
            check_lists(forest, batch, At::closest, Keep::nearest, 5, progress);
          }
        }
      }
  });
}
