// The library: on every instruction set of this machine, each query gives the answers of brute force, one ray at a time
// and in batches, with every kernel; files keep trees. Threads share a tree (ThreadSanitizer).
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <thread>

#include "library.hpp"

using fastlines::test::Scene;

namespace {

/// Scenes small enough for brute force.
std::vector<Scene> small_scenes() {
  std::vector<Scene> scenes = fastlines::test::scenes();
  std::erase_if(scenes, [](const Scene& scene) { return scene.lines.size() > 300; });
  return scenes;
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
    check(tree.any_hit(ray, radius, at) == !expected[i].empty(), "any hit of one ray");
    check(tree.count_hits(ray, radius, at) == expected[i].size(), "number of hits of one ray");
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
  const fl::Method methods[] = {fl::Method::best,  fl::Method::bvh_cl, fl::Method::bvh_ss, fl::Method::bvh_d2,
                                fl::Method::kd_cl, fl::Method::kd_d2,  fl::Method::beams};
  const Rays rays = fastlines::test::scattered(scene.lines, box, size);
  static std::size_t next = 0;
  for (const fl::At at : {fl::At::closest, fl::At::surface, fl::At::entry}) {
    fl::BuildOptions options;
    options.method = methods[next++ % std::size(methods)];
    check_answers(fl::build(segments, options), rays, expected_hits(prims, rays, at), at);
    check_answers(fl::build(cones, options), rays, expected_hits(round, rays, at), at);
  }
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
  in.close();
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
  check_cancel();
  check_files();
  check_threads();
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
