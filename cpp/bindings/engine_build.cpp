// Builds and refits of trees over segments.
#include "engine.hpp"
#include "engine/trees.hpp"
#include "fastlines/build/refit.hpp"
#include "primitives.hpp"
#include "tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

BuiltTree build(Input<float> segments, const Settings& settings, nb::object progress) {
  return build_tree(primitives_in<Segments>(segments), settings, progress);
}

/// The nodes of a tree, refitted to segments that have moved.
Output<std::uint32_t> refit_tree(Input<float> segments, Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                                 unsigned n_threads, nb::object progress) {
  const auto from = rows<Node>(nodes);
  auto to = make_array<std::uint32_t>(from.size(), sizeof(Node) / sizeof(std::uint32_t));
  Refit refit(from, rows<Reference>(refs), primitives_in<Segments>(segments), reinterpret_cast<Node*>(to.data()));
  watch_if(rows<Reference>(refs).size() > kLongPass, progress, [&](Progress& watched) { refit(n_threads, watched); });
  return to;
}

}  // namespace

void bind_build(nb::module_& m) {
  m.def("build", &build, "segments"_a.noconvert(), "settings"_a, "progress"_a.none());
  m.def("refit_tree", &refit_tree, "segments"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
