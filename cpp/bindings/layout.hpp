// A wide layout and its primitives as Python keeps them: checked once, then read by every query.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <span>

#include "arrays.hpp"
#include "fastlines/layout/wide_bvh.hpp"
#include "primitives.hpp"

namespace fastlines {

inline Box box_of(const std::array<float, 6>& corners) {
  return {{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
}

/// A wide layout and its primitives. It keeps the arrays alive that its spans and primitives point into.
class LayoutView {
 public:
  LayoutView(const std::string& kind, Input<float> data, Input<std::uint8_t> nodes_, Input<std::uint8_t> leaves_,
             Input<std::uint32_t> refs_, const std::array<float, 6>& corners, float mean_extent)
      : nodes(rows<WideNode>(nodes_)),
        leaves(rows<WideLeaf>(leaves_)),
        refs(rows<WideRef>(refs_)),
        prims(ray_primitives<QueryPrimitives>(kind, data)),
        box(box_of(corners)),
        frame(frame_of(box)),
        box_{frame(box.lo), frame(box.hi)},
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
  Box box;  ///< of the scene
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
                    const std::array<float, 6>&, float>(),
           "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "leaves"_a.noconvert(), "refs"_a.noconvert(),
           "corners"_a, "mean_extent"_a)
      .def_prop_ro("frame", &LayoutView::frame_of_queries);
}

}  // namespace fastlines
