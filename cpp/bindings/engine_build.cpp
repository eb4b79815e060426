// Builds and refits of trees over segments.
#include <nanobind/stl/string.h>

#include "engine.hpp"
#include "fastlines/build/refit.hpp"
#include "primitives.hpp"
#include "tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

BuiltTree build(const std::string& kind, Input<float> data, const Settings& settings, nb::object progress) {
  return std::visit([&](const auto& prims) { return build_tree(prims, settings, progress); },
                    ray_primitives(kind, data));
}

/// The nodes of a tree, refitted to segments that have moved.
Output<std::uint32_t> refit_tree(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes,
                                 Input<std::uint32_t> refs, unsigned n_threads, nb::object progress) {
  const auto from = rows<Node>(nodes);
  auto to = make_array<std::uint32_t>(from.size(), sizeof(Node) / sizeof(std::uint32_t));
  std::visit(
      [&](const auto& prims) {
        Refit refit(from, rows<Reference>(refs), prims, reinterpret_cast<Node*>(to.data()));
        watch_if(rows<Reference>(refs).size() > kLongPass, progress,
                 [&](Progress& watched) { refit(n_threads, watched); });
      },
      ray_primitives(kind, data));
  return to;
}

}  // namespace

void bind_build(nb::module_& m) {
  m.def("build", &build, "kind"_a, "data"_a.noconvert(), "settings"_a, "progress"_a.none());
  m.def("refit_tree", &refit_tree, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(),
        "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
