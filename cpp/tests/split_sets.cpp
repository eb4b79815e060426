// Every split set, and the one of docs/extending.md: the counts and boxes of a candidate are those of the children that
// `partition` makes of it, for both box rules.
#include "check.hpp"
#include "fastlines/splits/partition.hpp"
#include "fastlines/splits/split_set.hpp"
#include "scenes.hpp"
#include "thirds.hpp"

using namespace fastlines;
using test::check;

namespace {

Buffer<BuildRef> refs_to(const Segments& prims) {
  Buffer<BuildRef> refs;
  BuildRef* const data = refs.reset(prims.size());
  for (std::uint32_t prim = 0; prim < prims.size(); ++prim) data[prim] = {{prim}, prims.bounds(prim)};
  refs.set_size(prims.size());
  return refs;
}

Refs view_of(const Buffer<BuildRef>& refs) { return {refs.begin(), refs.end()}; }

bool same(const Box& a, const Box& b) { return a.lo == b.lo && a.hi == b.hi; }

/// Check a candidate of one node. `exact` tells whether its boxes must be those of the children to the last bit.
void check_candidate(const Segments& prims, Refs refs, const Box& box, BoxRule rule, const Candidate& split,
                     bool exact) {
  Buffer<BuildRef> left, right;
  partition(prims, refs, split, left, right);
  check(left.size() == split.n_left && right.size() == split.n_right, "partition makes the counts of the candidate");
  const bool is_plane = split.kind == Candidate::Kind::plane;
  check(is_plane || rule == BoxRule::tight, "an object split is offered only where boxes are tight");
  if (rule == BoxRule::cut) {
    const auto [low, high] = halves(box, split.axis, split.plane);
    check(same(split.left, low) && same(split.right, high), "a plane cuts the box in two");
  } else if (exact || !is_plane) {
    check(same(split.left, hull(view_of(left))) && same(split.right, hull(view_of(right))),
          "the boxes of the candidate bound its children");
  }
}

/// Check visit(prims, refs, box, rule, visitor) on the root of each scene. It offers something somewhere, except for
/// cut boxes if it needs tight ones.
template <class Visit>
void check_set(bool exact, bool tight_only, const Visit& visit) {
  for (const BoxRule rule : {BoxRule::tight, BoxRule::cut}) {
    std::size_t n = 0;
    for (const test::Scene& scene : test::scenes()) {
      const Segments prims{scene.lines};
      const Buffer<BuildRef> refs = refs_to(prims);
      const Box box = bounds_of_all(prims);
      visit(prims, view_of(refs), box, rule, [&](const Candidate& split) {
        ++n;
        check_candidate(prims, view_of(refs), box, rule, split, exact);
      });
    }
    check((n > 0) == (rule == BoxRule::tight || !tight_only), "the set offers splits where it should");
  }
}

template <class Set>
void check_set(const Set& set) {
  const Splits splits{{SplitSet(set)}};
  check_set(!estimates(splits), Set::kTightOnly,
            [&](const auto& prims, Refs refs, const Box& box, BoxRule rule, const auto& visitor) {
              visit_splits(splits, prims, refs, box, rule, {}, true, visitor);
            });
}

/// Without its limit on references, a set of object splits takes part where planes are not allowed.
template <class Set>
void check_uncut(const Set& set) {
  const test::Lines lines = test::long_lines(20);
  const Segments prims{lines};
  const Buffer<BuildRef> refs = refs_to(prims);
  const auto count = [&](const auto& visit) {
    std::size_t n = 0;
    visit([&](const Candidate& split) { n += split.kind != Candidate::Kind::plane; });
    return n;
  };
  const Box box = bounds_of_all(prims);
  const std::size_t n = count([&](const auto& add) { set.visit(prims, view_of(refs), box, BoxRule::tight, add); });
  const Splits splits{{SplitSet(set), 2}};
  check(n > 0 && n == count([&](const auto& add) { visit_uncut(splits, prims, view_of(refs), box, {}, add); }),
        "object splits are offered to nodes of any size");
}

template <class... Set>
void check_all(std::type_identity<std::variant<Set...>>) {
  const auto check_each = []<class Each>(const Each& set) {
    check_set(set);
    if constexpr (Each::kTightOnly) check_uncut(set);
  };
  (check_each(Set{}), ...);
}

/// Planes near x = 0 cut a line through x = 0 at the same s, so all pieces but two are empty. Their order is still
/// total.
void check_empty_pieces() {
  const Segment line{{-1, 0, 0}, {1, 0, 0}};
  const Segments prims{{&line, 1}};
  Buffer<BuildRef> refs;
  BuildRef* const data = refs.reset(64);
  data[0] = {{0}, line.bounds()};
  for (std::size_t i = 0; i + 1 < 64; ++i) {
    data[i + 1] = data[i];
    cut(prims, 0, float(i) * 1e-12f, data[i], data[i + 1]);
  }
  refs.set_size(64);
  check(data[1].ref.s0 == data[62].ref.s1, "pieces are empty");
  ObjectSweep{}.visit(prims, view_of(refs), line.bounds(), BoxRule::tight, [&](const Candidate& split) {
    check_candidate(prims, view_of(refs), line.bounds(), BoxRule::tight, split, true);
  });
}

/// Four points on the x axis: the thirds of their box are at x = 3 and 6.
void check_thirds() {
  std::vector<Segment> points;
  for (const float x : {0.0f, 4.0f, 5.0f, 9.0f}) points.push_back({{x, 0, 0}, {x, 0, 0}});
  const Segments prims{points};
  const Buffer<BuildRef> refs = refs_to(prims);
  std::vector<std::pair<float, std::size_t>> found;
  Thirds{}.visit(prims, view_of(refs), bounds_of_all(prims), BoxRule::tight,
                 [&](const Candidate& split) { found.push_back({split.plane, split.n_left}); });
  check(found == std::vector<std::pair<float, std::size_t>>{{3.0f, 1}, {6.0f, 3}}, "the thirds are offered");
}

}  // namespace

int main() {
  return test::run([] {
    check_all(std::type_identity<SplitSet>());
    check_set(BinnedPlanes{.uncut_refs = 10'000});
    check_set(true, Thirds::kTightOnly, [](const auto&... node) { Thirds{}.visit(node...); });
    check_empty_pieces();
    check_thirds();
  });
}
