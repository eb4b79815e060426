// Builds trees over a set of primitives that the library does not know: balls. The builder needs only the size of the
// set, bounds, and bounds clipped to a box. The trees keep all axioms.
#include <random>

#include "check.hpp"
#include "fastlines/core.hpp"

using namespace fastlines;

namespace {

struct Ball {
  Vec3 centre;
  float radius;
};

struct Balls {
  std::vector<Ball> data;

  std::size_t size() const { return data.size(); }

  Box bounds(std::uint32_t prim) const {
    const auto& [centre, radius] = data[prim];
    const Vec3 half{radius, radius, radius};
    return {centre - half, centre + half};
  }

  /// Conservative: the ball's box clipped to the other.
  Box clipped_bounds(std::uint32_t prim, const Box& box) const {
    Box both = bounds(prim);
    for (int k = 0; k < 3; ++k) {
      both.lo[k] = std::max(both.lo[k], box.lo[k]);
      both.hi[k] = std::min(both.hi[k], box.hi[k]);
    }
    return both.is_empty() ? Box::empty() : both;
  }
};
static_assert(Primitives<Balls>);
static_assert(!Curves<Balls>);

void build_over_balls() {
  Balls balls;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  for (int i = 0; i < 500; ++i) balls.data.push_back({{uniform(random), uniform(random), uniform(random)}, 0.02f});

  for (const BoxRule rule : {BoxRule::tight, BoxRule::cut})
    for (const SplitSet& set :
         {SplitSet{PlaneGrid{8}}, SplitSet{PlaneEvents{}}, SplitSet{Median{}}, SplitSet{Midpoint{}}}) {
      Settings settings;
      settings.boxes = rule;
      settings.splits = {{set}};
      Progress progress;
      const Tree tree = Builder(balls, settings, progress).build();
      const auto violation = validate(balls, tree.nodes, tree.refs, rule);
      test::check(tree.nodes.size() >= 3, "the root is split");
      test::check(!violation, violation ? (violation->axiom + ", " + violation->detail).c_str() : "");
      progress.cancel = true;
      bool stopped = false;
      try {
        validate(balls, tree.nodes, tree.refs, rule, progress);
      } catch (const Cancelled&) {
        stopped = true;
      }
      test::check(stopped, "a validation can be cancelled");
    }
}

}  // namespace

int main() { return test::run(build_over_balls); }
