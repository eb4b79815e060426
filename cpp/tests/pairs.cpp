// Finds the pairs of small scenes with the kernel, on one tree and on two, and compares them with brute force, bit for
// bit. A digest of all pairs is the same on every machine and for every instruction set.
#include <bit>
#include <cinttypes>

#include "check.hpp"
#include "fastlines/kernels/proximity/pair_search.hpp"
#include "fastlines/query/proximity/all_pairs.hpp"
#include "query_matrix.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

/// The digest of all pairs below. If it differs, answers have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0x05df36b157bef486;

/// A tree over round cones, and what a search reads of it.
struct Tested {
  std::vector<RoundCone> cones;
  Tree tree;
  WideBvh wide;

  Tested(const Lines& lines, float radius, Progress& progress) {
    Random random{7};
    for (const Segment& line : lines) {
      const float thick = random.below(3) == 0 ? 0.0f : radius;
      cones.push_back({line, thick * random.uniform(), thick * random.uniform()});
    }
    tree = build(Segments{lines}, progress);
    wide = collapse(tree.nodes, tree.refs, RoundCones(cones), {.radius_hint = 0.001}, 1, progress);
  }

  PairTree view() const { return {wide.frame, wide.nodes, wide.leaves, wide.refs}; }
};

std::vector<std::uint32_t> words_of(const PairColumns& pairs) {
  std::vector<std::uint32_t> words;
  for (std::size_t n = 0; n < pairs.i.size(); ++n) {
    for (const std::int64_t id : {pairs.i[n], pairs.j[n]}) words.push_back(std::uint32_t(id));
    for (const float x : {pairs.s[n], pairs.t[n], pairs.distance[n]}) words.push_back(std::bit_cast<std::uint32_t>(x));
  }
  return words;
}

PairColumns find(const PairQuery& query, const PairTree& first, const PairTree& second, unsigned n_threads) {
  Progress progress;
  PairList list(query);
  if (query.surface)
    PairSearch<true>{query, first, second}.find(list, n_threads, progress, {});
  else
    PairSearch<false>{query, first, second}.find(list, n_threads, progress, {});
  return list.sorted(n_threads, progress, {});
}

/// Compare all ways to find the pairs of a query; returns their number.
std::size_t compare(const PairQuery& query, const PairTree& first, const PairTree& second, std::uint64_t& digest) {
  Progress progress;
  const auto expected = words_of(all_pairs<float>(query, 1, progress));
  check(words_of(all_pairs<FloatX16>(query, 2, progress)) == expected, "16 pairs at a time are those of brute force");
  for (const unsigned n_threads : {1u, 3u})
    check(words_of(find(query, first, second, n_threads)) == expected,
          "the pairs of a search are those of brute force");
  if (!query.is_self) {
    const PairTree rows{query.frame, {}, {}, {}};
    check(words_of(find(query, rows, second, 1)) == expected, "the pairs of rows without a tree are the same");
  }
  for (const std::uint32_t word : expected) digest = (digest ^ word) * 0x100'0000'01b3;
  return expected.size() / 5;
}

/// Find the pairs of a scene, and those with another.
std::size_t find_all(const Lines& lines, std::uint64_t& digest) {
  Progress progress;
  Box box = bounds_of_all(Segments{lines});
  const float size = std::max(float(box.side(box.longest_axis())), 1e-9f);
  const Tested one(lines, 0.05f * size, progress);
  const Tested other(moved(hair(4), size, box.lo[0]), 0.01f * size, progress);
  std::size_t n_pairs = 0;
  for (const bool surface : {false, true})
    for (const float radius : {0.0f, 0.003f * size, 0.1f * size}) {
      const AxisSet axes = axes_of(RoundCones(one.cones));
      PairQuery query{axes, axes, true, one.wide.frame, radius, surface, {}};
      n_pairs += compare(query, one.view(), one.view(), digest);
      query.begin = std::int64_t(lines.size() / 3);
      query.end = query.begin + 10;
      n_pairs += compare(query, one.view(), one.view(), digest);
      Box both = box;
      both.grow(bounds_of_all(RoundCones(other.cones)));
      const PairQuery joined{axes, axes_of(RoundCones(other.cones)), false, frame_of(both), radius, surface, {}};
      n_pairs += compare(joined, one.view(), other.view(), digest);
    }
  return n_pairs;
}

/// Neighbours along an open and a closed strand.
void test_neighbours() {
  std::vector<StrandNeighbours::Place> places;
  for (std::int32_t i = 0; i < 6; ++i) places.push_back({0, i});
  for (std::int32_t i = 0; i < 6; ++i) places.push_back({1, i});
  places.push_back({-1, 0});
  places.push_back({-1, 1});
  const std::vector<std::int32_t> periods{0, 6};
  const StrandNeighbours neighbours{places, periods, 1};
  check(neighbours.has(2, 3) && !neighbours.has(2, 4), "neighbours are next to each other");
  check(!neighbours.has(0, 5), "the ends of an open strand are no neighbours");
  check(neighbours.has(6, 11), "those of a closed one are");
  check(!neighbours.has(5, 6), "strands have no common neighbours");
  check(!neighbours.has(12, 13), "what is in no strand has none");
}

}  // namespace

int main() {
  return run([] {
    test_neighbours();
    std::uint64_t digest = 0xcbf2'9ce4'8422'2325;
    for (const Scene& scene : scenes())
      check(find_all(scene.lines, digest) > 0 || scene.lines.size() == 1, "there are pairs");
    if (digest != kDigest) std::printf("the digest of all pairs is %016" PRIx64 "\n", digest);
    check(digest == kDigest, "the digest of all pairs is unchanged");
  });
}
