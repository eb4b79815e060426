// Chains of a hundred wide nodes, deeper than any builder makes them, so that traversal stacks have to grow. A stack
// grows by a level per step if every node leaves a child waiting, and more slowly if that child is visited first.
// Wavefronts and single rays still give the right answers.
#include <memory>

#include "check.hpp"
#include "fastlines/kernels/run/run_batch.hpp"

using namespace fastlines;

namespace {

constexpr int kDepth = 100, kRays = 300;
constexpr float kFrom = -2.0f, kScale = 4.0f / 255.0f;  // blocks reach from −2 to 2

WideNode node_of(int n_inner, int n_children, int first_inner) {
  WideNode node{};
  for (float& at : node.org) at = kFrom;
  node.scale = kScale;
  node.n_inner = std::uint8_t(n_inner);
  node.n_children = std::uint8_t(n_children);
  node.first_inner = std::uint32_t(first_inner);
  for (int k = 3; k < 6; ++k) std::fill_n(node.planes + k * kSimdWidth, n_children, std::uint8_t(255));
  return node;
}

/// A chain in which each node has two inner children, one of them empty. The first child continues the chain, or both
/// take turns. The deepest node has the leaf.
std::vector<WideNode> nodes_of(bool in_turn) {
  std::vector<WideNode> nodes(2 * kDepth + 1, node_of(0, 0, 0));
  std::size_t at = 0;
  for (int depth = 0; depth < kDepth; ++depth) {
    const int first = 1 + 2 * depth;
    nodes[at] = node_of(2, 2, first);
    at = std::size_t(first + (in_turn ? depth % 2 : 0));
  }
  nodes[at] = node_of(0, 1, 0);
  return nodes;
}

void answer_in_deep_trees() {
  const Segment segment{{-1.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}};
  const std::vector<WideRef> refs(kSimdWidth, WideRef(Reference{0}));
  WideLeaf leaf{};
  for (float& from : leaf.org) from = kFrom;
  leaf.scale = kScale;
  leaf.inv_scale = 1.0f / kScale;
  leaf.n_refs = 1;
  std::fill(std::begin(leaf.ends), std::end(leaf.ends), std::uint8_t(128));
  const Box box{{-2.0f, -2.0f, -2.0f}, {2.0f, 2.0f, 2.0f}};
  const Frame frame{.centre = {0.0f, 0.0f, 0.0f}, .scale = 1.0f, .overhang = 1e-5f};

  // Every third ray passes through all boxes but misses the segment.
  std::vector<Vec3> origins, directions(kRays, Vec3{0.0f, 0.0f, 1.0f});
  const auto hits = [](int ray) { return ray % 3 != 0; };
  for (int i = 0; i < kRays; ++i) origins.push_back({float(i % 7) * 1e-4f, hits(i) ? 0.0f : 0.5f, -5.0f});
  const float radius = 0.01f, t_min = 0.0f, t_max = 100.0f;
  const RayBatch rays{origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}};

  int n_hits = 0, n_wrong = 0;
  for (const auto& [kernel, in_turn] :
       {std::pair{Kernel::wave, false}, {Kernel::wave, true}, {Kernel::single, false}, {Kernel::single, true}}) {
    const std::vector<WideNode> nodes = nodes_of(in_turn);
    const WideBvhView<Segments> tree{frame, box, 1.0f, nodes.data(), &leaf, refs.data(), &segment};
    std::vector<float> t(kRays), u(kRays), distance(kRays);
    std::vector<std::int64_t> prim(kRays);
    const auto any = std::make_unique<bool[]>(kRays);
    Progress progress;
    const auto run = [&](const auto& query) { run_batch(tree, rays, kernel, query, 1, progress); };
    run(FirstHitQuery<Segments, At::closest>{tree, {t.data(), prim.data(), u.data(), distance.data(), nullptr}});
    run(AnyHitQuery{any.get()});
    for (int i = 0; i < kRays; ++i) {
      n_hits += prim[std::size_t(i)] == 0;
      n_wrong += (prim[std::size_t(i)] == 0) != hits(i);
      n_wrong += any[std::size_t(i)] != hits(i);
    }
  }
  test::check(n_hits == 800, "two of three rays hit, with each kernel and each tree");
  test::check(n_wrong == 0, "all answers are right");
}

}  // namespace

int main() { return test::run(answer_in_deep_trees); }
