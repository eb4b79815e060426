// Chains of a hundred wide nodes, deeper than any builder makes them, so that traversal stacks have to grow. A stack
// grows by a level per step if every node leaves a child waiting, and more slowly if that child is visited first.
// Wavefronts and single rays still give the right answers.
#include <memory>

#include "chains.hpp"
#include "check.hpp"
#include "fastlines/kernels/run/run_batch.hpp"

using namespace fastlines;
using namespace fastlines::test;

namespace {

void answer_in_deep_trees() {
  int n_hits = 0, n_wrong = 0;
  constexpr std::pair<Kernel, ChildOfDepth> setups[] = {{Kernel::wave, first_child},
                                                        {Kernel::wave, child_in_turn},
                                                        {Kernel::single, first_child},
                                                        {Kernel::single, child_in_turn}};
  for (const auto& [kernel, child] : setups) {
    const Chain chain(child);
    const WideBvhView<Segments> tree = chain.view();
    const RayBatch rays = chain.rays();
    std::vector<float> t(kRays), u(kRays), distance(kRays);
    std::vector<std::int64_t> prim(kRays);
    const auto any = std::make_unique<bool[]>(kRays);
    Progress progress;
    const auto run = [&](const auto& query) { run_batch(tree, rays, kernel, query, 1, progress); };
    run(FirstHitQuery<Segments, FixedAt<At::closest>>{tree,
                                                      {t.data(), prim.data(), u.data(), distance.data(), nullptr}});
    run(AnyHitQuery<>{any.get()});
    for (int i = 0; i < kRays; ++i) {
      n_hits += prim[std::size_t(i)] == 0;
      n_wrong += (prim[std::size_t(i)] == 0) != Chain::hits(i);
      n_wrong += any[std::size_t(i)] != Chain::hits(i);
    }
  }
  check(n_hits == 800, "two of three rays hit, with each kernel and each tree");
  check(n_wrong == 0, "all answers are right");
}

}  // namespace

int main() { return run(answer_in_deep_trees); }
