// All queries, brute force, and the bits of answers, for tests that compare the two.
#pragma once

#include <bit>
#include <memory>

#include "scenes.hpp"

namespace fastlines::test {

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
  if (has_exit(at)) to.add(hits.t_out[i]);
  to.add(std::int64_t(hits.prim[i]));
}

enum class Ask { first, any, count, all, k_nearest };

struct Case {
  const char* name;
  Ask query;
  At at;
};
constexpr Case kCases[] = {{"first", Ask::first, At::closest},
                           {"first at the surface", Ask::first, At::surface},
                           {"any", Ask::any, At::closest},
                           {"count", Ask::count, At::closest},
                           {"all", Ask::all, At::closest},
                           {"all at the surface", Ask::all, At::surface},
                           {"k nearest", Ask::k_nearest, At::closest},
                           {"k nearest at the surface", Ask::k_nearest, At::surface},
                           {"first entry", Ask::first, At::entry},
                           {"any entry", Ask::any, At::entry},
                           {"count of entries", Ask::count, At::entry},
                           {"all entries", Ask::all, At::entry},
                           {"k nearest entries", Ask::k_nearest, At::entry}};
constexpr std::size_t kNearest = 20;  // the k of the k nearest hits: more than a vector holds

/// Answers queries by brute force. It stores first hits, flags and counts in place, and fills lists.
template <RayPrimitive P>
struct Brute {
  BruteForce<P> search;
  const RayBatch& rays;
  unsigned n_threads = 1;
  Progress& progress;

  void first(At at, const HitColumns& to) const {
    first_hits(search, rays, at, n_threads, progress, [&](std::size_t i, const Hit& hit) { to.set(i, hit); });
  }
  void any(At at, std::span<bool> to) const { any_hits(search, rays, at, n_threads, progress, to); }
  void count(At at, std::span<std::int64_t> to) const { count_hits(search, rays, at, n_threads, progress, to); }
  void all(At at, HitAssembler& to) const { list_hits(search, rays, n_threads, progress, to, at); }
  void k_nearest(At at, HitAssembler& to) const {
    list_hits(search, rays, n_threads, progress, to, at, Keep::first, kNearest);
  }
};

template <class Backend>
Answers answer(const Backend& backend, const Case& test_case) {
  const auto [name, query, at] = test_case;
  const std::size_t n = backend.rays.size();
  Answers answers;
  if (query == Ask::all || query == Ask::k_nearest) {
    HitAssembler lists(n, has_exit(at));
    if (query == Ask::all)
      backend.all(at, lists);
    else
      backend.k_nearest(at, lists);
    const auto offsets = lists.offsets();
    for (std::size_t ray = 0; ray < n; ++ray) {
      for (auto i = std::size_t(offsets[ray]); i < std::size_t(offsets[ray + 1]); ++i) put(lists, i, at, answers);
      answers.end();
    }
    return answers;
  }
  Hits hits(n);
  const std::unique_ptr<bool[]> found(new bool[n]);
  if (query == Ask::first) backend.first(at, hits.columns());
  if (query == Ask::any) backend.any(at, {found.get(), n});
  if (query == Ask::count) backend.count(at, hits.prim);
  for (std::size_t ray = 0; ray < n; ++ray) {
    if (query == Ask::first) put(hits, ray, at, answers);
    if (query == Ask::any) answers.add(std::int64_t(found[ray]));
    if (query == Ask::count) answers.add(hits.prim[ray]);
    answers.end();
  }
  return answers;
}

/// The tree of method "best".
template <RayPrimitive P>
Tree build(const P& prims, Progress& progress) {
  Settings settings;
  settings.splits = {{PlaneGrid{16}}, {ObjectSweep{}, 32}};
  settings.bad_levels = 3;
  settings.prune = false;
  settings.radius_hint = 0.001;
  settings.cost.c_trav = 4.0;
  settings.limits.max_leaf_refs = 16;
  settings.lanes = 16;
  return Builder(prims, settings, progress).build();
}

/// Rays of all kinds for a scene whose box is this one.
inline std::vector<Rays> rays_of(const Lines& lines, const Box& box) {
  const auto size = float(box.side(box.longest_axis()));
  const Vec3 outside{0.3f, 0.2f, 2.2f}, inside{0.05f, -0.1f, 0.02f};
  return {picture("from outside", outside, 1.3f, box, size, 0.0f),
          picture("from outside", outside, 0.02f, box, size, 0.002f),
          picture("from outside", outside, 1.3f, box, size, 0.01f),
          picture("from inside", inside, 2.0f, box, size, 0.05f), scattered(lines, box, size)};
}

}  // namespace fastlines::test
