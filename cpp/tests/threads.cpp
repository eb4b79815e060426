// Everything that runs on several threads, small enough for ThreadSanitizer (`.ci/sanitize thread`): builds, layouts,
// refits, reinsertion, all queries with every kernel, concurrent callers, and calls that are cancelled midway. Answers
// and trees equal those of one thread.
#include <algorithm>
#include <cstring>
#include <random>

#include "check.hpp"
#include "fastlines/core.hpp"
#include "fastlines/parallel/run_watched.hpp"
#include "fastlines/rays/ray_check.hpp"

using namespace fastlines;

namespace {

constexpr unsigned kThreads = 4;
constexpr std::size_t kRays = 2048, kNearest = 5;

template <class A, class B>
void expect_same(const A& a, const B& b) {
  using T = std::remove_cvref_t<decltype(a[0])>;
  test::check(a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0, "both are equal");
}

void expect_same(const Tree& a, const Tree& b) {
  expect_same(a.nodes, b.nodes);
  expect_same(a.refs, b.refs);
}

void expect_same(const WideBvh& a, const WideBvh& b) {
  expect_same(a.nodes, b.nodes);
  expect_same(a.leaves, b.leaves);
  expect_same(a.refs, b.refs);
}

std::vector<Segment> lines(int n) {
  std::mt19937 random(1);
  const auto uniform = [&] { return float(random()) * 0x1p-32f; };
  std::vector<Segment> lines;
  for (int i = 0; i < n; ++i) {
    const Vec3 p{uniform(), uniform(), uniform()};
    lines.push_back({p, i % 50 ? p + Vec3{uniform(), uniform(), uniform()} * 0.05f : Vec3{uniform(), 1.0f, uniform()}});
  }
  return lines;
}

struct Rays {
  std::vector<Vec3> origins, directions;
  float radius = 0.01f, t_min = 0.0f, t_max = 10.0f;

  /// Coherent or incoherent rays. Every fourth chunk hits nothing. The length of lists is estimated from such chunks,
  /// so the lists have to grow while hits are stored.
  explicit Rays(bool coherent) {
    std::mt19937 random(2);
    const auto uniform = [&] { return float(random()) * 0x1p-32f; };
    for (std::size_t i = 0; i < kRays; ++i) {
      const bool hits = i / 64 % 4 != 0 && i / 256 % 4 != 0;
      const float across = coherent ? 0.02f * float(i % 64) : uniform();
      origins.push_back({hits ? across : 50.0f, coherent ? 0.01f * float(i / 64) : uniform(), -1.0f});
      directions.push_back(coherent ? Vec3{0, 0, 1} : Vec3{uniform() - 0.5f, uniform() - 0.5f, 1.0f});
    }
  }

  RayBatch batch() const { return {origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}}; }
};

/// The answers to a batch, as bytes.
struct Answer {
  std::vector<std::byte> bytes;

  template <class Values>
  void add(const Values& values, std::size_t n) {
    const auto* const data = reinterpret_cast<const std::byte*>(values.data());
    bytes.insert(bytes.end(), data, data + n * sizeof(values.data()[0]));
  }
  void add(HitAssembler& lists) {
    const auto offsets = lists.offsets();
    const auto n = std::size_t(offsets[kRays]);
    add(offsets, offsets.size());
    for (const Buffer<float>* column : {&lists.t, &lists.u, &lists.distance}) add(*column, n);
    if (lists.with_t_out()) add(lists.t_out, n);
    add(lists.prim, n);
  }
  std::size_t size() const { return bytes.size(); }
  const std::byte* data() const { return bytes.data(); }
  const std::byte& operator[](std::size_t i) const { return bytes[i]; }
};

/// Runs all queries on the layout.
Answer answer(const WideBvhView<Segments>& tree, const RayBatch& rays, Kernel kernel, unsigned n_threads,
              Progress& progress) {
  Answer answer;
  std::vector<float> t(kRays), u(kRays), distance(kRays), t_out(kRays);
  std::vector<std::int64_t> prim(kRays);
  const HitColumns to{t.data(), prim.data(), u.data(), distance.data(), t_out.data()};
  run_batch(tree, rays, kernel, FirstHitQuery<Segments, SurfaceAt>{tree, to}, n_threads, progress);
  for (const auto* column : {&t, &u, &distance, &t_out}) answer.add(*column, kRays);
  answer.add(prim, kRays);
  const std::unique_ptr<bool[]> any(new bool[kRays]);
  run_batch(tree, rays, kernel, AnyHitQuery<>{any.get()}, n_threads, progress);
  answer.add(std::span(any.get(), kRays), kRays);
  run_batch(tree, rays, kernel, CountHitsQuery{prim.data()}, n_threads, progress);
  answer.add(prim, kRays);
  HitAssembler all(kRays, true), next(kRays, false);
  run_lists(tree, rays, kernel, AllHitsQuery<Segments>(tree, At::surface), n_threads, progress, all);
  run_lists(tree, rays, kernel, KNearestQuery<Segments, FixedAt<At::closest>>(tree, kNearest), n_threads, progress,
            next);
  answer.add(all);
  answer.add(next);
  return answer;
}

/// Runs queries on the binary tree.
Answer answer(const BinaryTraversal<Segments>& search, const RayBatch& rays, unsigned n_threads, Progress& progress) {
  Answer answer;
  std::vector<Hit> hits(kRays);
  std::vector<std::int64_t> n_hits(kRays);
  first_hits(search, rays, At::closest, n_threads, progress, [&](std::size_t i, const Hit& hit) { hits[i] = hit; });
  count_hits(search, rays, At::closest, n_threads, progress, n_hits);
  for (const Hit& hit : hits) answer.add(std::span(&hit.t, 1), 1);
  answer.add(n_hits, kRays);
  HitAssembler all(kRays, false);
  list_hits(search, rays, n_threads, progress, all, At::closest);
  answer.add(all);
  return answer;
}

Settings settings(unsigned n_threads) {
  Settings settings;
  settings.splits = {{PlaneGrid{16}}, {ObjectSweep{}, 32}};
  settings.bad_levels = 2;
  settings.presplit.area = 1e-3;
  settings.limits.max_leaf_refs = 16;
  settings.n_threads = n_threads;
  return settings;
}

/// Makes a call and cancels it from another thread as soon as it reports progress. It may end before it is cancelled.
template <class Call>
void cancel(Call&& call) {
  Progress progress;
  std::atomic<bool> over = false;
  std::thread other([&] {
    while (progress.done == 0.0 && !over) std::this_thread::yield();
    progress.cancel = true;
  });
  try {
    call(progress);
  } catch (const Cancelled&) {
  }
  over = true;
  other.join();
}

/// Makes a call again and again, until its poll ends it.
template <class Call>
void end_by_poll(Call&& call) {
  const std::thread::id caller = std::this_thread::get_id();
  int n_polls = 0;
  bool by_caller = true;
  double last = 0.0;
  const auto poll = [&](double done) {
    by_caller &= std::this_thread::get_id() == caller && last <= done && done <= 1.0;
    last = done;
    return ++n_polls < 2;
  };
  const auto endless = [&](Progress& own) {
    for (;;) call(own);
  };
  test::check(run_polling(endless, poll) != nullptr && n_polls == 2, "a call ends when its poll says so");
  test::check(by_caller, "the thread that calls polls, with a fraction that does not fall");
}

void run_threads() {
  const std::vector<Segment> segments = lines(2500);
  const auto build = [&](unsigned n_threads, Progress& progress) {
    const Settings of = settings(n_threads);
    return Builder(Segments{segments}, of, progress).build();
  };
  const auto move = [](const Tree& tree, unsigned n_threads, Progress& progress) {
    return Reinsertion(tree.nodes, tree.refs, {.rounds = 1, .n_threads = n_threads}, progress)();
  };
  const auto lay_out = [&](const Tree& tree, unsigned n_threads, Progress& progress) {
    return collapse(tree.nodes, tree.refs, Segments{segments}, {}, n_threads, progress);
  };
  const auto refit = [&](const Tree& tree, unsigned n_threads, Progress& progress) {
    std::vector<Node> nodes(tree.nodes.size());
    Refit(tree.nodes, tree.refs, Segments{segments}, nodes.data())(n_threads, progress);
    return nodes;
  };

  // Compare trees and layouts with those of one thread.
  Progress progress;
  const Tree tree = build(1, progress);
  const WideBvh wide = lay_out(tree, 1, progress);
  expect_same(tree, build(kThreads, progress));
  expect_same(move(tree, 1, progress), move(tree, kThreads, progress));
  expect_same(wide, lay_out(tree, kThreads, progress));
  expect_same(refit(tree, 1, progress), refit(tree, kThreads, progress));

  // Compare the answers of queries on several threads, and of concurrent callers.
  const WideBvhView<Segments> view = view_of(wide, Segments{segments});
  const BinaryTraversal<Segments> search{tree.nodes, tree.refs, {segments}, view.frame};
  for (const bool coherent : {true, false}) {
    const Rays rays(coherent);
    const RayBatch batch = rays.batch();
    test::check(!!check_rays(batch, 1.0f, 1.0f, kThreads).valid, "the rays are valid");
    for (const Kernel kernel : {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle}) {
      const Answer expected = answer(view, batch, kernel, 1, progress);
      expect_same(expected, answer(view, batch, kernel, kThreads, progress));
    }
    const Answer expected = answer(search, batch, 1, progress);
    const Answer wide_expected = answer(view, batch, Kernel::automatic, 1, progress);
    std::vector<std::thread> callers;
    for (int i = 0; i < 3; ++i)
      callers.emplace_back([&] {
        Progress own;
        expect_same(expected, answer(search, batch, 2, own));
        expect_same(wide_expected, answer(view, batch, Kernel::automatic, 2, own));
      });
    for (std::thread& caller : callers) caller.join();

    // Cancel calls midway.
    cancel([&](Progress& own) { answer(view, batch, Kernel::automatic, kThreads, own); });
    cancel([&](Progress& own) { answer(search, batch, kThreads, own); });

    // End calls that poll.
    for (const Kernel kernel : {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle})
      end_by_poll([&](Progress& own) { answer(view, batch, kernel, 1, own); });
    end_by_poll([&](Progress& own) { answer(search, batch, 1, own); });
  }
  cancel([&](Progress& own) { build(kThreads, own); });
  cancel([&](Progress& own) { move(tree, kThreads, own); });
  cancel([&](Progress& own) { lay_out(tree, kThreads, own); });
  end_by_poll([&](Progress& own) { lay_out(tree, kThreads, own); });
  end_by_poll([&](Progress& own) { refit(tree, kThreads, own); });
}

}  // namespace

int main() { return test::run(run_threads); }
