// The library: on every instruction set of this machine, each query gives the answers of brute force, one ray at a time
// and in batches, with every kernel; files keep trees; bad input is refused. Threads share a tree (ThreadSanitizer).
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <thread>

#include "check.hpp"
#include "fastlines/fastlines.hpp"
#include "scenes.hpp"

using fastlines::test::check;
using fastlines::test::Scene;

namespace {

/// Scenes small enough for brute force.
std::vector<Scene> small_scenes() {
  std::vector<Scene> scenes = fastlines::test::scenes();
  std::erase_if(scenes, [](const Scene& scene) { return scene.lines.size() > 300; });
  return scenes;
}

std::vector<fl::Segment> segments_of(const std::vector<fastlines::Segment>& lines) {
  std::vector<fl::Segment> segments;
  for (const auto& [p, q] : lines) segments.push_back({{p[0], p[1], p[2]}, {q[0], q[1], q[2]}});
  return segments;
}

/// The same lines with radii that differ from end to end.
std::vector<fl::RoundCone> cones_of(const std::vector<fl::Segment>& segments, float size) {
  std::vector<fl::RoundCone> cones;
  for (std::size_t i = 0; i < segments.size(); ++i)
    cones.push_back({segments[i].p, segments[i].q, size * 0.01f * float(i % 3), size * 0.01f * float(i % 5)});
  return cones;
}

struct Rays {
  std::vector<fl::Vec3> origins, directions;
  std::vector<float> radius, t_min, t_max;

  Rays(const fastlines::test::Rays& from) {
    const auto batch = from.batch();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const fastlines::RayQuery ray = batch[i];
      origins.push_back({ray.origin[0], ray.origin[1], ray.origin[2]});
      directions.push_back({ray.direction[0], ray.direction[1], ray.direction[2]});
      radius.push_back(ray.radius);
      t_min.push_back(ray.t_min);
      t_max.push_back(ray.t_max);
    }
  }
  std::size_t size() const { return origins.size(); }
  fl::Ray one(std::size_t i) const { return {origins[i], directions[i], t_min[i], t_max[i]}; }
  fl::Rays all() const { return {origins, directions, std::span<const float>(t_min), std::span<const float>(t_max)}; }
};

bool same(const fl::Hit& a, const fl::Hit& b) {
  return a.t == b.t && a.prim == b.prim && a.u == b.u && a.distance == b.distance && a.t_out == b.t_out;
}
template <class A, class B>
bool same_lists(const A& a, const B& b) {
  bool equal = a.size() == b.size();
  for (std::size_t i = 0; equal && i < a.size(); ++i) equal = same(a[i], b[i]);
  return equal;
}

/// All hits of each ray by brute force.
template <class P>
std::vector<std::vector<fl::Hit>> expected_hits(const P& prims, const Rays& rays, fl::At at) {
  const fastlines::At core_at = at == fl::At::surface ? fastlines::At::surface : fastlines::At::closest;
  fastlines::Box box = fastlines::bounds_of_all(prims);
  const fastlines::BruteForce<P> brute{prims, fastlines::frame_of(box, fastlines::max_radius_of(prims))};
  std::vector<std::vector<fl::Hit>> found;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto &o = rays.origins[i], &d = rays.directions[i];
    const fastlines::Ray ray = fastlines::prepare(
        {{o.x, o.y, o.z}, {d.x, d.y, d.z}, rays.t_min[i], rays.t_max[i], rays.radius[i]}, brute.frame);
    found.emplace_back();
    fastlines::HitVectorOfRay<fl::Hit> list(ray, core_at, fastlines::Keep::all, found.back());
    typename fastlines::BruteForce<P>::Scratch scratch;
    brute(ray, list, scratch);
    list.finish();
    if (at == fl::At::surface)
      for (fl::Hit& hit : found.back()) hit.t_out = fastlines::exit_of(brute, ray, hit.prim);
  }
  return found;
}

void check_answers(const fl::Tree& tree, const Rays& rays, const std::vector<std::vector<fl::Hit>>& expected,
                   fl::At at) {
  static constexpr std::size_t k = 3;
  using Kernel = fl::QueryOptions::Kernel;
  const auto first_of = [](const std::vector<fl::Hit>& hits) { return hits.empty() ? fl::Hit() : hits[0]; };
  const auto next_of = [](const std::vector<fl::Hit>& hits) {
    return std::vector(hits.begin(), hits.begin() + std::ptrdiff_t(std::min(k, hits.size())));
  };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const fl::Ray ray = rays.one(i);
    const float radius = rays.radius[i];
    check(same(tree.first_hit(ray, radius, at), first_of(expected[i])), "first hit of one ray");
    check(tree.any_hit(ray, radius) == !expected[i].empty(), "any hit of one ray");
    check(tree.count_hits(ray, radius) == expected[i].size(), "number of hits of one ray");
    check(same_lists(tree.all_hits(ray, radius, at), expected[i]), "all hits of one ray");
    check(same_lists(tree.next_hits(ray, radius, k, at), next_of(expected[i])), "next hits of one ray");
  }
  for (const Kernel kernel : {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle}) {
    const fl::QueryOptions options{.at = at, .kernel = kernel, .n_threads = 2, .progress = {}};
    const std::span<const float> radius = rays.radius;
    const fl::Hits first = tree.first_hit(rays.all(), radius, options);
    const auto any = tree.any_hit(rays.all(), radius, options);
    const auto counts = tree.count_hits(rays.all(), radius, options);
    const fl::HitLists all = tree.all_hits(rays.all(), radius, options);
    const fl::HitLists next = tree.next_hits(rays.all(), radius, k, options);
    check(first.size() == rays.size() && all.n_rays() == rays.size(), "one answer for each ray");
    for (std::size_t i = 0; i < rays.size(); ++i) {
      check(same(first[i], first_of(expected[i])), "first hits of a batch");
      check(bool(any[i]) == !expected[i].empty(), "any hits of a batch");
      check(std::size_t(counts[i]) == expected[i].size(), "numbers of hits of a batch");
      check(same_lists(all[i], expected[i]), "all hits of a batch");
      check(same_lists(next[i], next_of(expected[i])), "next hits of a batch");
    }
    std::size_t n_given = 0;
    tree.all_hits(
        rays.all(), radius,
        [&](std::size_t ray, const fl::Hits& hits) {
          check(ray == n_given++ && same_lists(hits, expected[ray]), "all hits, handed to a sink");
        },
        options);
    check(n_given == rays.size(), "a sink is called for each ray");
  }
}

void check_scene(const Scene& scene) {
  const fastlines::Segments prims{scene.lines};
  const fastlines::Box box = fastlines::bounds_of_all(prims);
  const float size = std::max(box.side(box.longest_axis()) > 0 ? float(box.side(box.longest_axis())) : 1.0f, 1e-30f);
  const std::vector<fl::Segment> segments = segments_of(scene.lines);
  const std::vector<fl::RoundCone> cones = cones_of(segments, size);
  std::vector<fastlines::RoundCone> core_cones;
  for (std::size_t i = 0; i < cones.size(); ++i)
    core_cones.push_back({scene.lines[i], cones[i].radius_p, cones[i].radius_q});
  const fastlines::RoundCones round(core_cones);
  const fl::Method methods[] = {fl::Method::best,   fl::Method::bvh_cl, fl::Method::bvh_ss,
                                fl::Method::bvh_d2, fl::Method::kd_cl,  fl::Method::kd_d2};
  const Rays rays = fastlines::test::scattered(scene.lines, box, size);
  static std::size_t next = 0;
  for (const fl::At at : {fl::At::closest, fl::At::surface}) {
    fl::BuildOptions options;
    options.method = methods[next++ % std::size(methods)];
    check_answers(fl::build(segments, options), rays, expected_hits(prims, rays, at), at);
    check_answers(fl::build(cones, options), rays, expected_hits(round, rays, at), at);
  }
}

/// What a call throws, or an empty text.
template <class Error, class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

void check_bad_input() {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<fl::Segment> bad{{{0, 0, 0}, {1, 1, 1}}, {{0, nan, 0}, {1, 1, 1}}};
  const std::string why = message_of<fl::InputError>([&] { fl::build(bad); });
  check(why.find("line 1") != std::string::npos, "a bad line is named");
  const fl::Tree tree = fl::build(std::span(bad).first(1));
  const fl::Ray ray({0, 0, -5}, {0, 0, 1});
  const auto refuses = [&](const fl::Ray& of, float radius) {
    return !message_of<fl::InputError>([&] { tree.first_hit(of, radius); }).empty() &&
           !message_of<fl::InputError>([&] { tree.all_hits(of, radius); }).empty();
  };
  check(!refuses(ray, 0.5f), "a good ray is traced");
  check(refuses(ray, nan) && refuses(ray, -1), "a radius is a number that is not negative");
  check(refuses(fl::Ray({0, 0, nan}, {0, 0, 1}), 0), "origins are finite");
  check(refuses(fl::Ray({0, 0, 0}, {0, 0, 0}), 0), "directions are not zero");
  check(refuses(fl::Ray({0, 0, 0}, {0, 0, 1}, 2, 1), 0), "t_min is at most t_max");
  const std::vector<fl::Vec3> three(3), two(2);
  check(!message_of<fl::InputError>([&] { tree.all_hits(fl::Rays{three, three}, 0.1f, fl::Tree::Sink()); }).empty(),
        "an empty sink is refused");
  check(!message_of<fl::InputError>([&] { tree.first_hit(fl::Rays{three, two}, 0.1f); }).empty(), "sizes must match");
  check(!message_of<fl::InputError>([&] { tree.all_hits(fl::Rays{three, two}, 0.1f, [](auto, auto&&) {}); }).empty(),
        "sizes must match for a sink");
  check(!message_of<fl::InputError>([] { fl::set_simd("mmx"); }).empty(), "an unknown instruction set is refused");
  check(!message_of<fl::FileError>([] { fl::load("no/such/file.flt"); }).empty(), "a missing file is refused");
  check(!message_of<fl::FileError>([&] { tree.save("no/such/folder/a.flt"); }).empty(), "a missing folder is refused");
}

/// Null pointers and counts that cannot be: each is refused, and no call ends the process.
void check_nulls() {
  const auto is_refused = [](auto&& call) { return !message_of<fl::InputError>(call).empty(); };
  const float line[6] = {-1, -1, -1, 1, 1, 1};
  fl::BVH bvh;
  check(is_refused([&] { bvh.Build(nullptr, 2); }), "Build refuses a null array");
  check(is_refused([&] { bvh.Build(line, -1); }), "Build refuses a negative number of lines");
  check(is_refused([&] { bvh.Build(nullptr, std::numeric_limits<int>::max()); }), "Build refuses a huge null array");
  check(is_refused([&] { fl::AccTree(fl::Method(9)).Build(line, 1); }), "Build refuses an unknown method");
  bvh.Build(nullptr, 0);
  const fl::Ray ray({0, 0, -5}, {0, 0, 1});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  check(!bvh.Intersect(ray, nullptr, 1) && !bvh.IntersectAll(ray, nullptr, 1), "a tree over no lines misses");
  bvh.Build(line, 1);
  check(bvh.Intersect(ray, nullptr, 1) && bvh.IntersectAll(ray, nullptr, 1), "the hit may be null");
  check(is_refused([&] { bvh.Intersect(ray, nullptr, nan); }), "the distance is a number");
  check(is_refused([&] { bvh.IntersectAll(ray, nullptr, -1); }), "the distance is not negative");

  const auto null_of = []<class T>(T*, std::size_t n) { return std::span<const T>(static_cast<const T*>(nullptr), n); };
  for (const std::size_t n : {std::size_t(2), ~std::size_t(0)}) {
    check(is_refused([&] { fl::build(null_of((fl::Segment*)nullptr, n)); }), "null segments are refused");
    check(is_refused([&] { fl::build(null_of((fl::RoundCone*)nullptr, n)); }), "null round cones are refused");
  }
  check(is_refused([&] { fl::build(std::span(reinterpret_cast<const fl::Segment*>(line), ~std::size_t(0))); }),
        "more lines than there can be are refused");
  const fl::Tree& tree = bvh.tree();
  const auto nulls = null_of((fl::Vec3*)nullptr, 2);
  const auto null_floats = null_of((float*)nullptr, 2);
  const std::vector<fl::Vec3> origins(2, ray.origin), directions(2, ray.direction);
  const std::span<const fl::Vec3> too_many(origins.data(), ~std::size_t(0));
  const auto all_refuse = [&](const fl::Rays& rays, const fl::PerRay& radius, fl::QueryOptions options = {}) {
    return is_refused([&] { tree.first_hit(rays, radius, options); }) &&
           is_refused([&] { tree.any_hit(rays, radius, options); }) &&
           is_refused([&] { tree.count_hits(rays, radius, options); }) &&
           is_refused([&] { tree.all_hits(rays, radius, options); }) &&
           is_refused([&] { tree.next_hits(rays, radius, 2, options); }) &&
           is_refused([&] { tree.all_hits(rays, radius, [](auto, auto&&) {}, options); });
  };
  check(all_refuse({nulls, directions}, 1) && all_refuse({origins, nulls}, 1), "null rays are refused");
  check(all_refuse({origins, directions, null_floats}, 1), "a null t_min is refused");
  check(all_refuse({origins, directions, 0.0f, null_floats}, 1), "a null t_max is refused");
  check(all_refuse({origins, directions}, null_floats), "null radii are refused");
  check(all_refuse({origins, directions}, nan) && all_refuse({origins, directions}, -1), "radii are numbers from 0");
  check(all_refuse({origins, directions, nan}, 1), "t_min is a number");
  check(all_refuse({too_many, too_many}, 1), "more rays than there can be are refused");
  fl::QueryOptions unknown;
  unknown.kernel = fl::QueryOptions::Kernel(9);
  check(all_refuse({origins, directions}, 1, unknown), "an unknown kernel is refused");
  fl::QueryOptions many;
  many.n_threads = ~0u;
  const std::size_t most = ~std::size_t(0);
  check(
      tree.next_hits({origins, directions}, 1, most, many).hits.size() == 2 && tree.next_hits(ray, 1, most).size() == 1,
      "k and the number of threads may be huge");
  check(tree.next_hits({origins, directions}, 1, 0).hits.size() == 0 && tree.next_hits(ray, 1, 0).empty(),
        "k may be 0");
}

void check_empty() {
  const fl::Tree none;
  const fl::Ray ray({0, 0, -5}, {0, 0, 1});
  check(none.size() == 0 && !none.first_hit(ray, 1.0f) && none.all_hits(ray, 1.0f).empty(), "an empty tree misses");
  check(none.first_hit(fl::Rays{}, 0.1f).size() == 0, "an empty batch has an empty answer");
  check(fl::HitLists().n_rays() == 0, "no lists are those of no rays");
  fl::Tree from = none;
  const fl::Tree to = std::move(from);
  check(!from.first_hit(ray, 1.0f) && !to.first_hit(ray, 1.0f), "a tree that is moved from stays as it is");
}

void check_cancel() {
  const std::vector<fl::Segment> segments = segments_of(fastlines::test::hair(20'000));
  fl::BuildOptions options;
  options.method = fl::Method::kd_d2;
  options.progress = [](double) { return false; };
  check(!message_of<fl::Cancelled>([&] { fl::build(segments, options); }).empty(), "a build can be cancelled");
}

void check_files() {
  const std::string path = (std::filesystem::temp_directory_path() / "fastlines-test-library.flt").string();
  const auto scene = fastlines::test::hair(16);
  const std::vector<fl::Segment> segments = segments_of(scene);
  const fl::Tree of_segments = fl::build(segments), of_cones = fl::build(cones_of(segments, 1.0f));
  for (const fl::Tree& tree : {of_segments, of_cones}) {
    tree.save(path);
    const fl::Tree read = fl::load(path);
    const fl::TreeFacts a = tree.facts(), b = read.facts();
    check(a.n_nodes == b.n_nodes && a.n_refs == b.n_refs && a.cost == b.cost && a.method == b.method, "facts are kept");
    const fl::Ray ray({0.5f, 0.5f, -1}, {0, 0, 1});
    check(same_lists(tree.all_hits(ray, 0.05f), read.all_hits(ray, 0.05f)), "a file keeps the answers");
  }
  // Whatever byte is damaged, the file is refused.
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  for (std::size_t at = 0; at < bytes.size(); at += 97) {
    std::string damaged = bytes;
    damaged[at] = char(damaged[at] ^ 4);
    std::ofstream(path, std::ios::binary) << damaged;
    check(!message_of<fl::FileError>([&] { fl::load(path); }).empty(), "a damaged file is refused");
    std::ofstream(path, std::ios::binary) << bytes.substr(0, at);
    check(!message_of<fl::FileError>([&] { fl::load(path); }).empty(), "a truncated file is refused");
  }
  std::filesystem::remove(path);
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
  directions[150'000] = {0, 0, 0};
  const std::string why = message_of<fl::InputError>([&] { tree.all_hits(rays, 0.01f, count); });
  check(why.find("ray 150000") != std::string::npos && n_calls == 0, "a bad ray is named before any hit is given");
}

/// Numbers in files do not depend on the locale of the program.
void check_locale() {
  struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::string path = (std::filesystem::temp_directory_path() / "fastlines-test-locale.flt").string();
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Commas));
  fl::build(segments_of(fastlines::test::hair(2))).save(path);
  check(fl::load(path).facts().method == "best", "a file that was written with another locale can be read");
  std::locale::global(before);
  std::filesystem::remove(path);
}

/// A query in the destructor of a static object, when the thread's scratch memory is gone.
struct AtExit {
  const fl::Tree tree = fl::build(segments_of(fastlines::test::hair(2)));
  ~AtExit() { tree.all_hits(fl::Ray({0.5f, 0.5f, -1}, {0, 0, 1}), 1.0f); }
};

/// Eight threads ask one tree, one ray at a time.
void check_threads() {
  const std::vector<fl::Segment> segments = segments_of(fastlines::test::hair(150));
  const fl::Tree tree = fl::build(segments);
  const auto ask = [&](std::vector<fl::Hit>& to) {
    std::vector<fl::Hit> hits;
    for (int i = 0; i < 500; ++i) {
      const fl::Ray ray({float(i % 20) / 20, float(i / 20) / 25, -1}, {0.1f, 0.05f, 1});
      to.push_back(tree.first_hit(ray, 0.02f, fl::At::surface));
      tree.all_hits(ray, 0.02f, hits);
      to.insert(to.end(), hits.begin(), hits.end());
      tree.next_hits(ray, 0.02f, 2, hits);
      to.insert(to.end(), hits.begin(), hits.end());
    }
  };
  std::vector<fl::Hit> expected;
  ask(expected);
  std::vector<std::vector<fl::Hit>> found(8);
  std::vector<std::thread> threads;
  for (auto& of_thread : found) threads.emplace_back([&] { ask(of_thread); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& of_thread : found) check(same_lists(of_thread, expected), "threads do not disturb each other");
}

void check_library() {
  check_empty();
  check_nulls();
  check_bad_input();
  check_cancel();
  check_files();
  check_threads();
  check_sink();
  check_locale();
  static const AtExit at_exit;
  for (const char* simd : {"avx512", "avx2", "sse42", "neon", "portable"}) {
    if (!message_of<fl::InputError>([&] { fl::set_simd(simd); }).empty()) continue;
    check(std::string(fl::simd()) == simd && fl::build(std::span<const fl::Segment>()).facts().simd == simd,
          "the instruction set is the chosen one");
    std::printf("%s\n", simd);
    for (const Scene& scene : small_scenes()) check_scene(scene);
  }
  fl::set_simd(nullptr);
}

}  // namespace

int main() { return fastlines::test::run(check_library); }
