// Runs all queries on small scenes with every kernel and compares the answers with brute force, bit for bit. A digest
// of all answers is the same on every machine and for every instruction set.
#include <cinttypes>

#include "check.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

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
  void first(At at, const HitColumns& to) const {
    if (at == At::closest) return run(FirstHitQuery<Segments, FixedAt<At::closest>>{tree, to});
    run(FirstHitQuery<Segments, SurfaceAt>{tree, to, SurfaceAt(at)});
  }
  void any(At at, std::span<bool> to) const {
    if (at == At::entry) return run(AnyHitQuery<FixedAt<At::entry>>{to.data()});
    run(AnyHitQuery<>{to.data()});
  }
  void count(At at, std::span<std::int64_t> to) const {
    if (at == At::entry) return run(CountEntriesQuery{to.data()});
    run(CountHitsQuery{to.data()});
  }
  void all(At at, HitAssembler& to) const { list(AllHitsQuery<Segments>(tree, at), to); }
  void k_nearest(At at, HitAssembler& to) const {
    if (at == At::closest) return list(KNearestQuery<Segments, FixedAt<At::closest>>(tree, kNearest), to);
    list(KNearestQuery<Segments, SurfaceAt>(tree, kNearest, SurfaceAt(at)), to);
  }
};

/// The digest of all answers below. If it differs, answers have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0x915bd3a4e4cfe7b0;

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

/// Limits of rays: the t of one of the hits of each, or a little less; or none.
std::vector<float> limits_of(const Answers& expected, std::size_t n_words) {
  Random random{8};
  std::vector<float> limits;
  for (std::size_t ray = 0; ray < expected.ends.size(); ++ray) {
    const std::span<const std::uint32_t> hits = expected.of(ray);
    const bool is_any = !hits.empty() && random.below(8) > 0;
    const float t = is_any ? std::bit_cast<float>(hits[random.below(hits.size() / n_words) * n_words]) : kInfinity;
    limits.push_back(random.below(4) == 0 ? std::nextafter(t, 0.0f) : t);
  }
  return limits;
}

/// Whether the answer has all hits up to the limit; what follows may be missing, or be another hit.
bool is_complete(std::span<const std::uint32_t> given, std::span<const std::uint32_t> expected, std::size_t n_words,
                 float limit) {
  for (std::size_t i = 0; i < expected.size() && std::bit_cast<float>(expected[i]) <= limit; i += n_words)
    if (i + n_words > given.size() || !std::ranges::equal(given.subspan(i, n_words), expected.subspan(i, n_words)))
      return false;
  return true;
}

/// Whether first hits and the k nearest are found up to the limits of rays, and nothing is clipped there.
bool finds_up_to_limits(const WideBvhView<Segments>& view, const BruteForce<Segments>& brute, const RayBatch& rays,
                        const Setup& setup, Progress& progress) {
  for (const Case& test_case : kCases) {
    if (test_case.query != Ask::first && test_case.query != Ask::k_nearest) continue;
    const std::size_t n_words = n_hit_columns(test_case.at);
    const Answers expected = answer(Brute<Segments>{brute, rays, 1, progress}, test_case);
    const std::vector<float> limits = limits_of(expected, n_words);
    RayBatch limited = rays;
    limited.limit = limits;
    const Answers given[] = {answer(Engine{view, limited, setup.kernel, setup.n_threads, progress}, test_case),
                             answer(Brute<Segments>{brute, limited, 1, progress}, test_case)};
    for (const Answers& of : given)
      for (std::size_t ray = 0; ray < rays.size(); ++ray)
        if (!is_complete(of.of(ray), expected.of(ray), n_words, limits[ray])) {
          std::printf("kernel %s, query \"%s\": ray %zu misses a hit before its limit\n", setup.name, test_case.name,
                      ray);
          return false;
        }
  }
  return true;
}

/// Runs all queries on a scene. Returns false if an answer differs from that of brute force, or if no ray hits
/// anything.
bool agree(const Scene& scene, Digest& digest) {
  Progress progress;
  const Tree tree = build(Segments{scene.lines}, progress);
  const WideBvh wide = collapse(tree.nodes, tree.refs, Segments{scene.lines}, {.radius_hint = 0.001}, 1, progress);
  const WideBvhView<Segments> view = view_of(wide, Segments{scene.lines});
  std::size_t n_hits = 0;
  for (const Rays& rays : rays_of(scene.lines, tree.nodes[0].box)) {
    const RayBatch batch = rays.batch();
    for (const Case& test_case : kCases) {
      const Answers expected =
          answer(Brute<Segments>{{Segments{scene.lines}, view.frame}, batch, 1, progress}, test_case);
      digest.add(expected);
      if (test_case.query == Ask::all) n_hits += expected.words.size();
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
  for (const Rays& rays : rays_of(scene.lines, tree.nodes[0].box))
    for (const Setup& setup : kSetups)
      if (!finds_up_to_limits(view, {Segments{scene.lines}, view.frame}, rays.batch(), setup, progress)) return false;
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
