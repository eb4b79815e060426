// The plan that collapses a binary tree into a wide one has the cost that its definition gives. So no other choice of
// children is cheaper. fits_leaf agrees with merging the pieces.
#include <map>
#include <set>

#include "check.hpp"
#include "fastlines/core.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

std::vector<Segment> lines(Random& random, int n) {
  std::vector<Segment> lines;
  while (int(lines.size()) < n) {
    const Vec3 p = random.in_cube();
    lines.push_back({p, p + random.direction() * (lines.size() % 4 == 0 ? 2.0f : 0.1f)});
  }
  return lines;
}

bool fits_after_merging(std::span<const Reference> below) {
  std::vector<Reference> pieces(below.size());
  return merge_pieces(below, pieces.data()) <= kSimdWidth;
}

/// The formulas at the head of layout/collapse_plan.hpp, by recursion.
struct Definition {
  const Tree& tree;
  CollapseCost cost;
  double root_area, margin;
  std::map<std::pair<std::uint32_t, int>, double> memo = {};

  explicit Definition(const Tree& of, const CollapseCost& cost_) : tree(of), cost(cost_) {
    const Box& box = tree.nodes[0].box;
    margin = cost.radius_hint * box.side(box.longest_axis());
    root_area = box.area(margin);
  }

  /// The cost of v as one leaf.
  double as_leaf(std::uint32_t v) const {
    const Node& node = tree.nodes[v];
    const bool fits = fits_after_merging(std::span(tree.refs).subspan(node.first_ref, node.n_refs));
    return fits ? node.box.area(margin) / root_area * cost.c_leaf : std::numeric_limits<double>::infinity();
  }

  double least(std::uint32_t v, int n_children) {
    const auto found = memo.find({v, n_children});
    if (found != memo.end()) return found->second;
    const Node& node = tree.nodes[v];
    const double area = node.box.area(margin) / root_area;
    double best = std::numeric_limits<double>::infinity();
    if (n_children > 1) {
      best = std::min(least(v, n_children - 1), divided(v, n_children));
    } else {
      best = as_leaf(v);
      if (!node.is_leaf()) best = std::min(best, area * cost.c_node + divided(v, kSimdWidth));
    }
    return memo[{v, n_children}] = best;
  }

  double divided(std::uint32_t v, int n_children) {
    const Node& node = tree.nodes[v];
    double best = std::numeric_limits<double>::infinity();
    if (node.is_leaf()) return best;
    for (int k = 1; k < n_children; ++k) best = std::min(best, least(v + 1, k) + least(node.right, n_children - k));
    return best;
  }
};

bool near(double a, double b) { return a == b || std::abs(a - b) <= 1e-5 * (std::abs(a) + std::abs(b)); }

void check_plan(const std::vector<Segment>& segments, const CollapseCost& cost, double area_of_pieces) {
  Settings settings;
  settings.splits = {{PlaneGrid{8}}};
  if (area_of_pieces > 0.0) settings.presplit.area = area_of_pieces;
  settings.limits.max_leaf_refs = 8;
  Progress progress;
  const Tree tree = Builder(Segments{segments}, settings, progress).build();
  check(tree.nodes.size() > 10, "the tree has nodes");
  for (const unsigned n_threads : {1u, 2u}) {
    const Buffer<CollapsePlan> plans = CollapsePlanner(tree.nodes, tree.refs, cost)(n_threads, progress);
    Definition definition(tree, cost);
    for (std::uint32_t v = 0; v < tree.nodes.size(); ++v) {
      const CollapsePlan& plan = plans[v];
      const Node& node = tree.nodes[v];
      check(plan.leaf == (definition.as_leaf(v) <= definition.least(v, 1) * (1 + 1e-5)), "a leaf if that costs least");
      if (node.is_leaf()) continue;
      // The choices of the plan have the least cost.
      const auto cost_of_split = [&](int n, int k) {
        return definition.least(v + 1, k) + definition.least(node.right, n - k);
      };
      check(plan.k_all > 0 && plan.k_all < kSimdWidth, "a node of its own gives both sides some children");
      check(near(cost_of_split(kSimdWidth, plan.k_all), definition.divided(v, kSimdWidth)), "D(v, 16)");
      for (int n = 2; n <= plan.n_leaves; ++n) {
        const double by_plan = plan.k[n] > 0 ? cost_of_split(n, plan.k[n]) : definition.least(v, n - 1);
        check(near(definition.least(v, n), by_plan), "C(v, i) by the plan");
      }
      check(near(definition.least(v, plan.n_leaves), definition.least(v, kSimdWidth)), "more children are useless");
    }
  }
}

/// Checks lists of pieces of few or many segments, in any order.
void check_fits_leaf(Random& random) {
  for (int round = 0; round < 3000; ++round) {
    const std::size_t n_prims = 1 + random.below(24), n_pieces = 1 + random.below(8);
    std::vector<Reference> refs;
    for (std::size_t prim = 0; prim < n_prims; ++prim)
      for (std::size_t i = 0; i < n_pieces; ++i) {
        if (random.below(8) == 0) continue;  // a gap
        refs.push_back({std::uint32_t(97 * prim), float(i) / float(n_pieces), float(i + 1) / float(n_pieces)});
      }
    for (std::size_t i = refs.size(); i > 1; --i) std::swap(refs[i - 1], refs[random.below(i)]);
    if (refs.empty()) continue;
    check(fits_leaf(refs) == (refs.size() <= kMaxMergedRefs && fits_after_merging(refs)), "fits_leaf");
  }
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    for (int round = 0; round < 8; ++round)
      check_plan(lines(random, 60 + 20 * round), {.radius_hint = round % 2 ? 0.01 : 0.0}, round % 4 < 2 ? 0.0 : 1e-3);
    check_fits_leaf(random);
  });
}
