// Finds the pairs of small scenes with the kernel, on one tree and on two, and compares them with brute force, bit for
// bit. A digest of all pairs is the same on every machine and for every instruction set.
#include <algorithm>
#include <array>
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

/// The cones of one part of a scene, the number of each in the scene, and its place along a strand of ten.
struct Part {
  std::vector<std::int64_t> numbers;
  std::vector<StrandNeighbours::Place> places;
  std::vector<RoundCone> cones;
  Tree tree;
  WideBvh wide;

  Part(const Tested& whole, const std::vector<StrandNeighbours::Place>& places_of_whole, bool is_odd,
       Progress& progress) {
    Lines lines;
    Random random{11};
    for (std::size_t i = 0; i < whole.cones.size(); ++i) {
      if ((random.below(2) == 1) != is_odd) continue;
      numbers.push_back(std::int64_t(i));
      places.push_back(places_of_whole[i]);
      cones.push_back(whole.cones[i]);
      lines.push_back(whole.cones[i].axis);
    }
    if (lines.empty()) return;
    tree = build(Segments{lines}, progress);
    wide = collapse(tree.nodes, tree.refs, RoundCones(cones), {.radius_hint = 0.001}, 1, progress);
  }

  PairTree view() const { return {wide.frame, wide.nodes, wide.leaves, wide.refs}; }
};

using Words = std::vector<std::array<std::uint32_t, 5>>;

/// Add the pairs of two parts, or of one, by their numbers in the whole.
void add_pairs(const PairQuery& whole, const Part& first, const Part& second, Words& words) {
  if (first.cones.empty() || second.cones.empty()) return;
  PairQuery query = whole;
  query.first = axes_of(RoundCones(first.cones));
  query.second = axes_of(RoundCones(second.cones));
  query.is_self = &first == &second;
  query.numbers = {first.numbers, second.numbers};
  if (whole.neighbours.reach > 0) query.neighbours = {first.places, second.places, whole.neighbours.reach};
  const PairColumns found = find(query, first.view(), second.view(), 2);
  Progress progress;
  check(words_of(found) == words_of(all_pairs<float>(query, 1, progress)), "pairs of parts are those of brute force");
  for (std::size_t n = 0; n < found.i.size(); ++n) {
    const auto number = [](const Part& of, std::int64_t row) { return std::uint32_t(of.numbers[std::size_t(row)]); };
    words.push_back({number(first, found.i[n]), number(second, found.j[n]), std::bit_cast<std::uint32_t>(found.s[n]),
                     std::bit_cast<std::uint32_t>(found.t[n]), std::bit_cast<std::uint32_t>(found.distance[n])});
  }
}

/// The pairs of two parts of a scene are those of the whole, with and without neighbours along strands.
void compare_parts(const Tested& whole, PairQuery query) {
  Progress progress;
  std::vector<StrandNeighbours::Place> places;
  for (std::size_t i = 0; i < whole.cones.size(); ++i)
    places.push_back({std::int32_t(i / 10), std::int32_t(i % 10), i / 10 % 2 ? 10 : 0});
  const Part odd(whole, places, true, progress), even(whole, places, false, progress);
  for (const std::int32_t reach : {0, 1}) {
    if (reach > 0) query.neighbours = {places, places, reach};
    Words expected, found;
    const std::vector<std::uint32_t> words = words_of(all_pairs<float>(query, 1, progress));
    for (std::size_t at = 0; at < words.size(); at += 5)
      std::copy_n(words.data() + at, 5, expected.emplace_back().data());
    for (const Part* first : {&odd, &even})
      for (const Part* second : {&odd, &even}) add_pairs(query, *first, *second, found);
    std::sort(found.begin(), found.end());
    check(found == expected, "the pairs of parts are those of the whole");
  }
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
      PairQuery query{axes, axes, true, one.wide.frame, radius, surface};
      n_pairs += compare(query, one.view(), one.view(), digest);
      compare_parts(one, query);
      query.begin = std::int64_t(lines.size() / 3);
      query.end = query.begin + 10;
      n_pairs += compare(query, one.view(), one.view(), digest);
      Box both = box;
      both.grow(bounds_of_all(RoundCones(other.cones)));
      const PairQuery joined{axes, axes_of(RoundCones(other.cones)), false, frame_of(both), radius, surface};
      n_pairs += compare(joined, one.view(), other.view(), digest);
    }
  return n_pairs;
}

/// Neighbours along an open and a closed strand.
void test_neighbours() {
  std::vector<StrandNeighbours::Place> places;
  for (std::int32_t i = 0; i < 6; ++i) places.push_back({0, i, 0});
  for (std::int32_t i = 0; i < 6; ++i) places.push_back({1, i, 6});
  places.push_back({-1, 0, 0});
  places.push_back({-1, 1, 0});
  const StrandNeighbours neighbours{places, places, 1};
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
