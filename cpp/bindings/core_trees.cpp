// Builds over primitives that are not on the fast path, reinsertion, and the planes of a KD tree. The engine modules
// build over the others.
#include <nanobind/stl/string.h>

#include "core.hpp"
#include "fastlines/build/reinsertion.hpp"
#include "fastlines/query/plane_traversal.hpp"
#include "primitives.hpp"
#include "tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

BuiltTree build(const std::string& kind, Input<float> data, const Settings& settings, nb::object progress) {
  if (const auto prims = find_primitives<OtherPrimitives>(kind, data))
    return std::visit([&](const auto& found) { return build_tree(found, settings, progress); }, *prims);
  throw std::invalid_argument("the core builds no trees over " + kind);
}

/// The tree after reinsertion, and the number of moves that were dropped because they would have been too deep.
std::tuple<WordRows, WordRows, std::size_t> reinsert(Input<std::uint32_t> nodes, Input<std::uint32_t> refs, int rounds,
                                                     std::size_t max_depth, double radius_hint, unsigned n_threads,
                                                     nb::object progress) {
  Tree tree;
  std::size_t n_too_deep = 0;
  watch(
      [&](Progress& watched) {
        Reinsertion reinsertion(rows<Node>(nodes), rows<Reference>(refs), {rounds, max_depth, radius_hint, n_threads},
                                watched);
        tree = reinsertion();
        n_too_deep = reinsertion.n_too_deep();
      },
      progress);
  return {adopt<std::uint32_t>(std::move(tree.nodes)), adopt<std::uint32_t>(std::move(tree.refs)), n_too_deep};
}

/// A KD tree as plane nodes in the frame of a box, the primitive of each reference, and the depth.
std::tuple<WordRows, WordRows, std::uint32_t> planes(Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                                                     const Corners& frame_corners) {
  PlaneTree tree;
  const Frame frame = frame_of(box_of(frame_corners));
  watch_if(rows<Reference>(refs).size() > kLongPass, nb::none(), [&](Progress& watched) {
    tree = PlaneTreeWriter(rows<Node>(nodes), rows<Reference>(refs), frame)(watched);
  });
  return {adopt<std::uint32_t>(std::move(tree.nodes)), adopt<std::uint32_t>(std::move(tree.prims)), tree.depth};
}

}  // namespace

void bind_trees(nb::module_& m) {
  m.def("build", &build, "kind"_a, "data"_a.noconvert(), "settings"_a, "progress"_a.none());
  m.def("reinsert", &reinsert, "nodes"_a.noconvert(), "refs"_a.noconvert(), "rounds"_a, "max_depth"_a, "radius_hint"_a,
        "n_threads"_a, "progress"_a.none());
  m.def("planes", &planes, "nodes"_a.noconvert(), "refs"_a.noconvert(), "frame_corners"_a);
}

}  // namespace fastlines
