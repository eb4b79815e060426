// Builds wide layouts from a tree, and refits them to segments that have moved.
#include "engine.hpp"
#include "engine/trees.hpp"
#include "fastlines/rays/spread_ray.hpp"
#include "layout.hpp"
#include "tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Wide nodes or leaves as rows of 128 bytes.
using BlockRows = Output<std::uint8_t>;

/// The layout of a tree in the frame of a box: nodes, leaves, references, and the mean extent of a leaf.
std::tuple<BlockRows, BlockRows, WordRows, float> build_layout(const std::string& kind, Input<float> data,
                                                               Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                                                               const Corners& frame_corners, double radius_hint,
                                                               unsigned n_threads, nb::object progress) {
  WideBvh wide;
  watch_if(rows<Reference>(refs).size() > kLongPass, progress, [&](Progress& watched) {
    wide = std::visit(
        [&](const auto& prims) {
          return collapse(rows<Node>(nodes), rows<Reference>(refs), prims, {.radius_hint = radius_hint}, n_threads,
                          watched, box_of(frame_corners));
        },
        ray_primitives(kind, data));
  });
  return {adopt<std::uint8_t>(std::move(wide.nodes)), adopt<std::uint8_t>(std::move(wide.leaves)),
          adopt<std::uint32_t>(std::move(wide.refs)), wide.mean_extent};
}

/// The nodes and leaves of a layout, refitted to segments that have moved, and the mean extent of a leaf.
std::tuple<BlockRows, BlockRows, float> refit_layout(const LayoutView& layout, unsigned n_threads,
                                                     nb::object progress) {
  auto nodes = make_array<std::uint8_t>(layout.nodes.size(), sizeof(WideNode));
  auto leaves = make_array<std::uint8_t>(layout.leaves.size(), sizeof(WideLeaf));
  float extent = 0.0f;
  watch_if(layout.refs.size() > kLongPass, progress, [&](Progress& watched) {
    extent = std::visit(
        [&]<class P>(const P& prims) -> float {
          if constexpr (AxisPrimitive<P> && !kHasSpread<P>)
            return BlockEncoder(layout.frame, layout.nodes, layout.leaves, layout.refs, prims,
                                reinterpret_cast<WideNode*>(nodes.data()),
                                reinterpret_cast<WideLeaf*>(leaves.data()))(n_threads, watched);
          else
            throw std::invalid_argument("layouts of this kind of primitive are not refitted");
        },
        layout.prims);
  });
  return {nodes, leaves, extent};
}

}  // namespace

void bind_layout(nb::module_& m) {
  m.def("build_layout", &build_layout, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(),
        "frame_corners"_a, "radius_hint"_a, "n_threads"_a, "progress"_a.none());
  m.def("refit_layout", &refit_layout, "layout"_a, "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
