// A tree of the library gives its lines back, leaves some out of a query, follows them when they move, and hands all
// hits to a sink.
#include <cmath>
#include <cstring>
#include <random>

#include "library.hpp"

namespace {

/// A tree gives its lines back, and where its hits are.
void check_lines() {
  const std::vector<fl::Segment> segments = segments_of(fastlines::test::hair(16));
  const std::vector<fl::RoundCone> cones = cones_of(segments, 1.0f);
  std::vector<std::int64_t> strands(segments.size(), 7);
  fl::BuildOptions options;
  options.strands = strands;
  const fl::Tree of_segments = fl::build(segments, options), of_cones = fl::build(cones);
  const auto same_bytes = [](auto a, auto b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  };
  check(same_bytes(of_segments.segments(), std::span(segments)) && of_segments.round_cones().empty(), "segments");
  check(same_bytes(of_cones.round_cones(), std::span(cones)) && of_cones.segments().empty(), "round cones");
  check(same_bytes(of_segments.strands(), std::span(strands)) && of_cones.strands().empty(), "strands");
  const fl::RoundCone line = of_cones.line(4), thin = of_segments.line(4);
  check(line.radius_p == cones[4].radius_p && line.q.z == cones[4].q.z && thin.p.x == segments[4].p.x, "a line");
  for (const std::int64_t none : {std::int64_t(-1), std::int64_t(segments.size())})
    check(!message_of<fl::InputError>([&] { of_cones.line(none); }).empty(), "a line that is not there is refused");
  strands.pop_back();
  options.strands = strands;
  check(!message_of<fl::InputError>([&] { fl::build(segments, options); }).empty(), "strands must match the lines");

  const fl::Tree one = fl::build(std::vector<fl::Segment>{{{-1, 0, 0}, {1, 0, 0}}});
  const fl::Ray ray({0, 0, -5}, {0, 0, 2});
  const auto is = [](const fl::Vec3d& v, double x, double y, double z) { return v.x == x && v.y == y && v.z == z; };
  const fl::Hit hit = one.first_hit(ray, 0.5f, fl::At::surface);
  const auto [point, normal, tangent, outside] = one.place(ray, 0.5f, hit);
  check(is(point, 0, 0, -0.5) && is(normal, 0, 0, -1) && is(tangent, 1, 0, 0), "the place of a hit");
  check(outside.z < point.z && !one.any_hit(fl::Ray({0, 0, float(outside.z)}, {0.5f, 0, -1}), 0.5f), "outside");
  check(std::isnan(one.place(ray, 0.5f, one.first_hit(ray, 0.5f)).normal.x), "no normal at the closest approach");
  check(std::isnan(one.place(ray, 0.5f, fl::Hit()).point.x), "no place of a miss");
}

/// A sink gets no hits before all rays are checked, however many they are.
void check_sink() {
  constexpr std::size_t n = 200'000;
  const fl::Tree tree = fl::build(segments_of(fastlines::test::hair(16)));
  std::vector<fl::Vec3> origins(n, fl::Vec3{0.5f, 0.5f, -1}), directions(n, fl::Vec3{0, 0, 1});
  const fl::Rays rays{origins, directions};
  const std::vector<float> too_few(n / 2, 0.01f);
  std::size_t n_calls = 0;
  const auto count = [&](std::size_t, const fl::Hits&) { ++n_calls; };
  check(!message_of<fl::InputError>([&] { tree.all_hits(rays, too_few, count); }).empty(), "radii that do not match");
  const fl::Rays one{rays.origins.first(1), rays.directions.first(1)};
  tree.all_hits(one, 1.0f, [&](std::size_t, const fl::Hits& hits) {
    check(hits.size() > 0 && hits.size() == tree.count_hits(one[0], 1.0f),
          "a batch of one ray has the hits of the ray");
  });
  directions[150'000] = {0, 0, 0};
  const std::string why = message_of<fl::InputError>([&] { tree.all_hits(rays, 0.01f, count); });
  check(why.find("ray 150000") != std::string::npos && n_calls == 0, "a bad ray is named before any hit is given");
}

/// A sink gets all hits in order, and few of them are in memory at a time.
void check_memory_of_sink() {
  // Rays of the second half cross all lines, those of the first half none.
  constexpr std::size_t n_rays = 40'000, n_lines = 300, most = 1 << 21;
  std::vector<fl::Segment> segments;
  for (std::size_t i = 0; i < n_lines; ++i) segments.push_back({{-1, 0, float(i)}, {1, 0, float(i)}});
  const fl::Tree tree = fl::build(segments);
  std::vector<fl::Vec3> origins(n_rays, fl::Vec3{0, 9, -1});
  std::fill(origins.begin() + n_rays / 2, origins.end(), fl::Vec3{0, 0, -1});
  const std::vector<fl::Vec3> directions(n_rays, fl::Vec3{0, 0, 1});
  std::size_t n_given = 0, n_hits = 0, n_together = 0;
  std::shared_ptr<const void> together;
  double last = 0;
  fl::QueryOptions options;
  options.progress = [&](double done) {
    check(done >= last, "progress goes forwards");
    last = done;
    return true;
  };
  tree.all_hits(
      {origins, directions}, 0.1f,
      [&](std::size_t ray, const fl::Hits& hits) {
        check(ray == n_given++, "rays come in their order");
        check(hits.size() == (ray < n_rays / 2 ? 0 : n_lines) && (hits.size() == 0 || hits.prim[7] == 7), "all hits");
        n_together = hits.owner == together ? n_together + hits.size() : hits.size();
        check(n_together <= most, "few hits are in memory at a time");
        together = hits.owner;
        n_hits += hits.size();
      },
      options);
  check(n_given == n_rays && n_hits == n_lines * n_rays / 2, "each ray is handed over once");
}

/// Answers without some lines are those of brute force without them.
void check_ignored() {
  const auto hair = fastlines::test::hair(60);
  const std::vector<fl::Segment> segments = segments_of(hair);
  const fastlines::Box box = fastlines::bounds_of_all(fastlines::Segments{hair});
  const Rays rays = fastlines::test::scattered(hair, box, 1.0f);
  std::vector<std::int64_t> strands;
  for (std::size_t i = 0; i < segments.size(); ++i) strands.push_back(std::int64_t(i / 5) - 1);
  fl::BuildOptions build_options;
  build_options.strands = strands;
  const fl::Tree tree = fl::build(segments, build_options);
  const std::vector<std::int64_t> lines{9, -1, 3, 9}, some_strands{2, 0, 4};
  fl::Rays batch = rays.all();
  batch.ignore = lines;
  batch.ignore_strands = some_strands;
  for (const fl::At at : {fl::At::closest, fl::At::surface, fl::At::entry}) {
    auto expected = expected_hits(fastlines::Segments{hair}, rays, at);
    for (auto& hits : expected)
      std::erase_if(hits, [&](const fl::Hit& hit) {
        const std::int64_t strand = strands[std::size_t(hit.prim)];
        return hit.prim == 9 || hit.prim == 3 || strand == 2 || strand == 0 || strand == 4;
      });
    fl::QueryOptions options;
    options.at = at;
    const std::span<const float> radius = rays.radius;
    const fl::Hits first = tree.first_hit(batch, radius, options);
    const auto any = tree.any_hit(batch, radius, options);
    const auto counts = tree.count_hits(batch, radius, options);
    const fl::HitLists all = tree.all_hits(batch, radius, options), next = tree.next_hits(batch, radius, 2, options);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto& of_ray = expected[i];
      const fl::Ray ray = batch[i];
      const fl::Hit nearest = of_ray.empty() ? fl::Hit() : of_ray[0];
      check(same(first[i], nearest) && same(tree.first_hit(ray, radius[i], at), nearest), "first hit of the others");
      check(any[i] == !of_ray.empty() && tree.any_hit(ray, radius[i], at) == !of_ray.empty(), "any hit of the others");
      check(std::size_t(counts[i]) == of_ray.size() && tree.count_hits(ray, radius[i], at) == of_ray.size(),
            "their number");
      check(same_lists(all[i], of_ray) && same_lists(tree.all_hits(ray, radius[i], at), of_ray), "all of the others");
      check(next[i].size() == std::min<std::size_t>(2, of_ray.size()), "the first ones of the others");
    }
  }
  const auto is_refused = [&](auto&& change) {
    fl::Rays wrong = rays.all();
    change(wrong);
    return !message_of<fl::InputError>([&] { tree.first_hit(wrong, 0.1f); }).empty();
  };
  const std::vector<std::int64_t> too_large{std::int64_t(segments.size())}, negative{-2};
  check(is_refused([&](fl::Rays& wrong) { wrong.ignore = too_large; }), "a line that is not there");
  check(is_refused([&](fl::Rays& wrong) { wrong.ignore_strands = too_large; }), "a strand that is not there");
  check(is_refused([&](fl::Rays& wrong) { wrong.ignore = negative; }), "a line below -1");
  const std::span<const std::int64_t> null(static_cast<const std::int64_t*>(nullptr), 3);
  check(is_refused([&](fl::Rays& wrong) { wrong.ignore = null; }), "a null array");
  check(is_refused([&](fl::Rays& wrong) { wrong.spread = std::nanf(""); }), "a spread that is NaN");
  check(is_refused([&](fl::Rays& wrong) { wrong.spread = -1.0f; }), "a negative spread");
}

/// The nearest hits by distance, and rays with a spread.
void check_ranks_and_spreads() {
  const std::vector<fl::Segment> posts{{{0.1f, -1, 1}, {0.1f, 1, 1}}, {{0.05f, -1, 9}, {0.05f, 1, 9}}};
  const fl::Tree tree = fl::build(posts);
  fl::Ray ray({0, 0, 0}, {0, 0, 1});
  fl::QueryOptions options;
  options.rank = fl::Rank::distance;
  const std::vector<fl::Vec3> origins{ray.origin}, directions{ray.direction};
  const fl::Rays batch{origins, directions};
  check(tree.next_hits(ray, 0.5f, 1)[0].prim == 0, "the first hit by t");
  check(tree.next_hits(ray, 0.5f, 1, fl::At::closest, fl::Rank::distance)[0].prim == 1, "the nearest hit");
  check(tree.next_hits(batch, 0.5f, 1, options)[0].prim[0] == 1, "the nearest hit of a batch");
  check(!message_of<fl::InputError>([&] { tree.all_hits(batch, 0.5f, options); }).empty(), "a rank is for next_hits");
  ray.spread = 0.02f;
  check(tree.first_hit(ray, 0).prim == 1 && tree.count_hits(ray, 0) == 1, "a radius that grows along the ray");
  check(tree.next_hits(ray, 0.09f, 2, fl::At::closest, fl::Rank::distance).size() == 2, "and is added to the radius");
  check(!message_of<fl::InputError>([&] { tree.first_hit(ray, 0, fl::At::surface); }).empty(), "it has no surface");
}

/// A refitted tree answers as a new one does.
void check_refit() {
  const auto hair = fastlines::test::hair(60);
  const std::vector<fl::Segment> segments = segments_of(hair);
  std::vector<fl::Segment> moved = segments;
  for (std::size_t i = 0; i < moved.size(); ++i)
    for (fl::Vec3* end : {&moved[i].p, &moved[i].q}) end->x += 0.01f * float(i % 7), end->z *= 1.5f;
  const Rays rays = fastlines::test::scattered(hair, fastlines::bounds_of_all(fastlines::Segments{hair}), 1.0f);
  for (const fl::Method method : {fl::Method::best, fl::Method::kd_d2}) {
    fl::BuildOptions options;
    options.method = method;
    const fl::Tree tree = fl::build(segments, options).refit(moved), made = fl::build(moved, options);
    const fl::HitLists found = tree.all_hits(rays.all(), 0.05f), expected = made.all_hits(rays.all(), 0.05f);
    for (std::size_t i = 0; i < rays.size(); ++i) check(same_lists(found[i], expected[i]), "hits after a refit");
    check(tree.facts().method == (method == fl::Method::best ? "best" : "custom"), "a refit makes boxes tight");
    check(tree.line(3).p.x == moved[3].p.x, "a refitted tree has the new lines");
    check(!message_of<fl::InputError>([&] { tree.refit(std::span(moved).first(3)); }).empty(), "as many lines");
    check(!message_of<fl::InputError>([&] { tree.refit(cones_of(moved, 1)); }).empty(), "lines of the same kind");
  }
  check(fl::Tree().refit(std::span<const fl::Segment>()).size() == 0, "an empty tree can be refitted");
}

/// Rays that graze the scene, from near and far, alone and in a batch: only single rays are culled by the scene's box.
void check_grazing() {
  std::mt19937 random(8);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto sphere = [&] {
    const double z = uniform(-1, 1), angle = uniform(0, 6.2831853), side = std::sqrt(1 - z * z);
    return fl::Vec3d{side * std::cos(angle), side * std::sin(angle), z};
  };
  struct Setting {
    double size, offset;
  };
  for (const auto& [size, offset] : {Setting{1, 0}, {1e-20, 0}, {1e15, 1e14}, {1, 1e5}, {1e-3, 20}}) {
    for (const float own : {0.0f, 0.25f}) {
      const auto place = [&, size = size, offset = offset](double x) { return float(offset + size * x); };
      std::vector<fl::RoundCone> cones;
      for (int i = 0; i < 20; ++i) {
        const auto point = [&] {
          return fl::Vec3{place(uniform(-1, 1)), place(uniform(-1, 1)), place(uniform(-1, 1))};
        };
        cones.push_back({point(), point(), own * float(size), own * float(size * uniform(0, 1))});
      }
      cones[7].q = cones[7].p;
      const fl::Tree tree = fl::build(cones);
      const double reach_of_query = size * uniform(0, 0.1);
      std::vector<fl::Vec3> origins, directions;
      std::vector<float> t_min, t_max;
      for (int i = 0; i < 4000; ++i) {
        // Pass an end of a line at its reach, up to rounding, seen from a random side or along an axis.
        const fl::RoundCone& cone = cones[std::size_t(i) % cones.size()];
        const fl::Vec3d out = sphere(), other = sphere();
        fl::Vec3d d{out.y * other.z - out.z * other.y, out.z * other.x - out.x * other.z,
                    out.x * other.y - out.y * other.x};
        if (i % 4 == 0) d = {0, -out.z, out.y};
        if (i % 8 == 1) d = {-out.y, out.x, 0};
        const double reach = (double(cone.radius_p) + reach_of_query) * (1 + uniform(-1e-6, 1e-6));
        const double back = size * std::pow(10.0, uniform(-2, 5)) * (i % 16 == 3 ? 0 : 1),
                     scale = std::pow(10.0, uniform(-3, 3));
        const auto from = [&](float p, double o, double along) { return float(p + reach * o - back * along); };
        origins.push_back({from(cone.p.x, out.x, d.x), from(cone.p.y, out.y, d.y), from(cone.p.z, out.z, d.z)});
        directions.push_back({float(scale * d.x), float(scale * d.y), float(scale * d.z)});
        // End at the line, or begin there, or do neither.
        const auto at_line = float(back / scale * (1 + uniform(-1e-6, 1e-6)));
        t_min.push_back(i % 3 == 0 ? at_line : i % 5 == 0 ? -fl::infinity : 0);
        t_max.push_back(i % 3 == 1 ? at_line : fl::infinity);
        if (!(t_min.back() <= t_max.back())) t_min.back() = t_max.back();
      }
      const fl::Rays batch{origins, directions, std::span<const float>(t_min), std::span<const float>(t_max)};
      const auto radius = float(reach_of_query);
      const fl::HitLists all = tree.all_hits(batch, radius);
      std::size_t n_hit = 0;
      for (std::size_t i = 0; i < batch.size(); ++i) {
        const fl::Hits of_ray = all[i];
        check(same_lists(tree.all_hits(batch[i], radius), of_ray), "a grazing ray alone");
        check(tree.first_hit(batch[i], radius).prim == (of_ray.size() ? of_ray.prim[0] : -1), "its first hit");
        check(tree.any_hit(batch[i], radius) == (of_ray.size() > 0), "whether it hits");
        n_hit += of_ray.size() > 0;
      }
      check(n_hit > batch.size() / 10 && n_hit < batch.size(), "some rays hit, and some miss");
    }
  }
}

void check_all() {
  check_grazing();
  check_lines();
  check_ignored();
  check_ranks_and_spreads();
  check_refit();
  check_sink();
  check_memory_of_sink();
}

}  // namespace

int main() { return fastlines::test::run(check_all); }
