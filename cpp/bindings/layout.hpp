// A wide layout and its primitives as Python keeps them: checked once, then read by every query.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <span>

#include "arrays.hpp"
#include "fastlines/layout/wide_bvh.hpp"
#include "primitives.hpp"

namespace fastlines {

/// A wide layout and its primitives. It keeps the arrays alive that its spans and primitives point into.
class LayoutView {
 public:
  LayoutView(const std::string& kind, Input<float> data, Input<std::uint8_t> nodes_, Input<std::uint8_t> leaves_,
             Input<std::uint32_t> refs_, const Corners& corners, const Corners& frame_corners, float mean_extent,
             std::optional<float> max_radius)
      : nodes(rows<WideNode>(nodes_)),
        leaves(rows<WideLeaf>(leaves_)),
        refs(rows<WideRef>(refs_)),
        prims(ray_primitives<QueryPrimitives>(kind, data, max_radius)),
        frame_box(box_of(frame_corners)),
        frame(frame_of(frame_box)),
        box_{frame(box_of(corners).lo), frame(box_of(corners).hi)},
        mean_extent_(mean_extent),
        arrays_{std::move(data), std::move(refs_)},
        blocks_{std::move(nodes_), std::move(leaves_)} {}

  /// Calls use(view) with the WideBvhView of the kind of primitive at hand.
  template <class Use>
  auto with_view(Use&& use) const {
    return std::visit(
        [&](const auto& of) {
          return use(view_of(frame, box_, mean_extent_, nodes.data(), leaves.data(), refs.data(), of));
        },
        prims);
  }

  /// The frame of queries: centre, scale, overhang.
  std::tuple<Vec3, float, float> frame_of_queries() const {
    return with_view(
        [](const auto& view) { return std::tuple(view.frame.centre, view.frame.scale, view.frame.overhang); });
  }

  std::span<const WideNode> nodes;
  std::span<const WideLeaf> leaves;
  std::span<const WideRef> refs;
  QueryPrimitives prims;
  Box frame_box;  ///< what the frame is of: the box of the scene, or a larger one
  Frame frame;

 private:
  Box box_;  // of the scene, in the frame
  float mean_extent_;
  std::pair<Input<float>, Input<std::uint32_t>> arrays_;
  std::array<Input<std::uint8_t>, 2> blocks_;
};

inline void bind_layout_view(nanobind::module_& m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  nb::class_<LayoutView>(m, "LayoutView")
      .def(nb::init<const std::string&, Input<float>, Input<std::uint8_t>, Input<std::uint8_t>, Input<std::uint32_t>,
                    const Corners&, const Corners&, float, std::optional<float>>(),
           "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "leaves"_a.noconvert(), "refs"_a.noconvert(),
           "corners"_a, "frame_corners"_a, "mean_extent"_a, "max_radius"_a = nb::none())
      .def_prop_ro("frame", &LayoutView::frame_of_queries);
}

}  // namespace fastlines
