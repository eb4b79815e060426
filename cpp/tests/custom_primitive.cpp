// A set of primitives that the library does not know: balls. BoxX4, and bounds clipped to a box, are all that the
// builder asks for. The program fails if a tree over them breaks an axiom.
#include <cstdio>
#include <random>

#include "fastlines/fastlines.hpp"

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

  /// Conservative: the ball's box, cut.
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

}  // namespace

int main() {
  Balls balls;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  for (int i = 0; i < 500; ++i) balls.data.push_back({{uniform(random), uniform(random), uniform(random)}, 0.02f});

  int n_bad = 0;
  for (const BoxRule rule : {BoxRule::tight, BoxRule::cut})
    for (const SplitSet& set :
         {SplitSet{PlaneGrid{8}}, SplitSet{PlaneEvents{}}, SplitSet{Median{}}, SplitSet{Midpoint{}}}) {
      Settings settings;
      settings.boxes = rule;
      settings.splits = {{set}};
      Progress progress;
      const Tree tree = Builder(balls, settings, progress).build();
      const auto violation = validate(balls, tree.nodes, tree.refs, rule);
      std::printf("%zu nodes, %zu references: %s\n", tree.nodes.size(), tree.refs.size(),
                  violation ? (violation->axiom + ", " + violation->detail).c_str() : "valid");
      n_bad += violation.has_value() || tree.nodes.size() < 3;
      progress.cancel = true;
      try {
        validate(balls, tree.nodes, tree.refs, rule, progress);
        ++n_bad;
      } catch (const Cancelled&) {
      }
    }
  return n_bad;
}
