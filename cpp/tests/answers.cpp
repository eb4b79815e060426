// Runs all queries on small scenes with every kernel and compares the answers with brute force, bit for bit. A digest
// of all answers is the same on every machine and for every instruction set.
#include <bit>
#include <cinttypes>

#include "check.hpp"
#include "scenes.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

/// The bits of the answers to a batch; those of ray i end at ends[i].
struct Answers {
  std::vector<std::uint32_t> words;
  std::vector<std::size_t> ends;

  void add(float x) { words.push_back(std::bit_cast<std::uint32_t>(x)); }
  void add(std::int64_t n) { words.push_back(std::uint32_t(n)); }
  void end() { ends.push_back(words.size()); }

  std::span<const std::uint32_t> of(std::size_t ray) const {
    const std::size_t begin = ray ? ends[ray - 1] : 0;
    return std::span(words).subspan(begin, ends[ray] - begin);
  }
};

struct Hits {
  std::vector<float> t, u, distance, t_out;
  std::vector<std::int64_t> prim;

  explicit Hits(std::size_t n) : t(n), u(n), distance(n), t_out(n), prim(n) {}

  HitColumns columns() { return {t.data(), prim.data(), u.data(), distance.data(), t_out.data()}; }
};

/// Adds a hit; a hit at the surface also has t_out.
template <class Hits>
void put(const Hits& hits, std::size_t i, At at, Answers& to) {
  for (const float x : {hits.t[i], hits.u[i], hits.distance[i]}) to.add(x);
  if (at == At::surface) to.add(hits.t_out[i]);
  to.add(std::int64_t(hits.prim[i]));
}

enum Query { first, any, count, all, k_nearest };

struct Case {
  const char* name;
  Query query;
  At at;
};
constexpr Case kCases[] = {{"first", first, At::closest},
                           {"first at the surface", first, At::surface},
                           {"any", any, At::closest},
                           {"count", count, At::closest},
                           {"all", all, At::closest},
                           {"all at the surface", all, At::surface},
                           {"k nearest", k_nearest, At::closest},
                           {"k nearest at the surface", k_nearest, At::surface}};
constexpr std::size_t kNearest = 20;  // the k of the k nearest hits: more than a vector holds

/// Answers queries by brute force. Like Engine, it stores first hits, flags and counts in place and fills lists.
struct Brute {
  BruteForce<Segments> search;
  const RayBatch& rays;
  unsigned n_threads = 1;
  Progress& progress;

  template <At at>
  void first(const HitColumns& to) const {
    first_hits(search, rays, at, n_threads, progress, [&](std::size_t i, const Hit& hit) { to.set(i, hit); });
  }
  void any(std::span<bool> to) const { any_hits(search, rays, n_threads, progress, to); }
  void count(std::span<std::int64_t> to) const { count_hits(search, rays, n_threads, progress, to); }
  template <At at>
  void all(HitAssembler& to) const {
    list_hits(search, rays, n_threads, progress, to, [](const Ray& ray) { return AllSink(at, ray); });
  }
  template <At at>
  void k_nearest(HitAssembler& to) const {
    list_hits(search, rays, n_threads, progress, to, [](const Ray& ray) { return KNearestSink(at, ray, kNearest); });
  }
};

/// Answers queries with a kernel.
struct Engine {
  const WideBvhView<Segments>& tree;
  const RayBatch& rays;
  Kernel kernel;
  unsigned n_threads;
  Progress& progress;

  template <class Query>
  void run(const Query& query) const {
    run_batch(tree, rays, kernel, query, n_threads, progress);
  }
  template <class Query>
  void list(const Query& query, HitAssembler& to) const {
    run_lists(tree, rays, kernel, query, n_threads, progress, to);
  }
  template <At at>
  void first(const HitColumns& to) const {
    run(FirstHitQuery<Segments, at>{tree, to});
  }
  void any(std::span<bool> to) const { run(AnyHitQuery{to.data()}); }
  void count(std::span<std::int64_t> to) const { run(CountHitsQuery{to.data()}); }
  template <At at>
  void all(HitAssembler& to) const {
    list(AllHitsQuery<Segments, at>(tree), to);
  }
  template <At at>
  void k_nearest(HitAssembler& to) const {
    list(KNearestQuery<Segments, at>(tree, kNearest), to);
  }
};

template <At at, class Backend>
Answers answer(const Backend& backend, Query query) {
  const std::size_t n = backend.rays.size();
  Answers answers;
  if (query == all || query == k_nearest) {
    HitAssembler lists(n, at == At::surface);
    if (query == all)
      backend.template all<at>(lists);
    else
      backend.template k_nearest<at>(lists);
    const auto offsets = lists.offsets();
    for (std::size_t ray = 0; ray < n; ++ray) {
      for (auto i = std::size_t(offsets[ray]); i < std::size_t(offsets[ray + 1]); ++i) put(lists, i, at, answers);
      answers.end();
    }
    return answers;
  }
  Hits hits(n);
  const std::unique_ptr<bool[]> found(new bool[n]);
  if (query == first) backend.template first<at>(hits.columns());
  if (query == any) backend.any({found.get(), n});
  if (query == count) backend.count(hits.prim);
  for (std::size_t ray = 0; ray < n; ++ray) {
    if (query == first) put(hits, ray, at, answers);
    if (query == any) answers.add(std::int64_t(found[ray]));
    if (query == count) answers.add(hits.prim[ray]);
    answers.end();
  }
  return answers;
}

template <class Backend>
Answers answer(const Backend& backend, const Case& test_case) {
  return test_case.at == At::surface ? answer<At::surface>(backend, test_case.query)
                                     : answer<At::closest>(backend, test_case.query);
}

/// The digest of all answers below. If it differs, answers have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0x3c24fb3ec95035e2;

/// The FNV-1a hash, fed with words instead of bytes.
struct Digest {
  std::uint64_t value = 0xcbf2'9ce4'8422'2325;

  void add(std::uint64_t word) { value = (value ^ word) * 0x100'0000'01b3; }
  void add(const Answers& answers) {
    for (const std::uint32_t word : answers.words) add(word);
    for (const std::size_t end : answers.ends) add(end);
  }
};

struct Setup {
  const char* name;
  Kernel kernel;
  unsigned n_threads;
};
constexpr Setup kSetups[] = {{"automatic", Kernel::automatic, 1},
                             {"automatic on 3 threads", Kernel::automatic, 3},
                             {"single", Kernel::single, 1},
                             {"wave", Kernel::wave, 1},
                             {"bundle", Kernel::bundle, 1}};

/// The tree of method "best".
Tree build(const Lines& lines, Progress& progress) {
  Settings settings;
  settings.splits = {{PlaneGrid{16}}, {ObjectSweep{}, 32}};
  settings.bad_levels = 3;
  settings.prune = false;
  settings.radius_hint = 0.001;
  settings.cost.c_trav = 4.0;
  settings.limits.max_leaf_refs = 16;
  settings.lanes = 16;
  return Builder(Segments{lines}, settings, progress).build();
}

/// Runs all queries on a scene. Returns false if an answer differs from that of brute force, or if no ray hits
/// anything.
bool agree(const Scene& scene, Digest& digest) {
  Progress progress;
  const Tree tree = build(scene.lines, progress);
  const WideBvh wide = collapse(tree.nodes, tree.refs, Segments{scene.lines}, {.radius_hint = 0.001}, 1, progress);
  const WideBvhView<Segments> view = view_of(wide, Segments{scene.lines});
  const Box& box = tree.nodes[0].box;
  const auto size = float(box.side(box.longest_axis()));

  const Vec3 outside{0.3f, 0.2f, 2.2f}, inside{0.05f, -0.1f, 0.02f};
  const Rays all_rays[] = {picture("from outside", outside, 1.3f, box, size, 0.0f),
                           picture("from outside", outside, 0.02f, box, size, 0.002f),
                           picture("from outside", outside, 1.3f, box, size, 0.01f),
                           picture("from inside", inside, 2.0f, box, size, 0.05f), scattered(scene.lines, box, size)};
  std::size_t n_hits = 0;
  for (const Rays& rays : all_rays) {
    const RayBatch batch = rays.batch();
    for (const Case& test_case : kCases) {
      const Answers expected = answer(Brute{{{scene.lines}, view.frame}, batch, 1, progress}, test_case);
      digest.add(expected);
      if (test_case.query == all) n_hits += expected.words.size();
      for (const Setup& setup : kSetups) {
        const Answers given = answer(Engine{view, batch, setup.kernel, setup.n_threads, progress}, test_case);
        for (std::size_t ray = 0; ray < batch.size(); ++ray) {
          if (std::ranges::equal(given.of(ray), expected.of(ray))) continue;
          std::printf("%s: scene \"%s\", rays \"%s\", kernel %s, query \"%s\": ray %zu differs from brute force\n",
                      kSimd, scene.name.c_str(), rays.name.c_str(), setup.name, test_case.name, ray);
          return false;
        }
      }
    }
  }
  if (n_hits == 0) std::printf("%s: scene \"%s\": no ray hits anything\n", kSimd, scene.name.c_str());
  return n_hits > 0;
}

}  // namespace

int main() {
  return run([] {
    Digest digest;
    for (const Scene& scene : scenes()) check(agree(scene, digest), "all answers are those of brute force");
    if (digest.value != kDigest) std::printf("the digest of all answers is %016" PRIx64 "\n", digest.value);
    check(digest.value == kDigest, "the digest of all answers is unchanged");
  });
}
