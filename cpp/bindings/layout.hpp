// A wide layout and its segments as Python keeps them: checked once, then read by every query.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>

#include <span>

#include "arrays.hpp"
#include "fastlines/layout/wide_bvh.hpp"

namespace fastlines {

inline Box box_of(const std::array<float, 6>& corners) {
  return {{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
}

/// Keeps the arrays alive that its spans and its view point into.
class LayoutView {
 public:
  LayoutView(Input<float> segments_, Input<std::uint8_t> nodes_, Input<std::uint8_t> leaves_,
             Input<std::uint32_t> refs_, const std::array<float, 6>& corners, float mean_extent)
      : nodes(rows<WideNode>(nodes_)),
        leaves(rows<WideLeaf>(leaves_)),
        refs(rows<WideRef>(refs_)),
        prims{rows<Segment>(segments_)},
        arrays_{std::move(segments_), std::move(refs_)},
        blocks_{std::move(nodes_), std::move(leaves_)} {
    const Box box = box_of(corners);
    const Frame frame = frame_of(box);
    view = {.frame = frame,
            .box = {frame(box.lo), frame(box.hi)},
            .mean_extent = mean_extent,
            .nodes = nodes.data(),
            .leaves = leaves.data(),
            .refs = refs.data(),
            .items = prims.items()};
  }

  std::span<const WideNode> nodes;
  std::span<const WideLeaf> leaves;
  std::span<const WideRef> refs;
  Segments prims;
  WideBvhView<Segments> view;

 private:
  std::pair<Input<float>, Input<std::uint32_t>> arrays_;
  std::array<Input<std::uint8_t>, 2> blocks_;
};

inline void bind_layout_view(nanobind::module_& m) {
  namespace nb = nanobind;
  using namespace nb::literals;
  nb::class_<LayoutView>(m, "LayoutView")
      .def(nb::init<Input<float>, Input<std::uint8_t>, Input<std::uint8_t>, Input<std::uint32_t>,
                    const std::array<float, 6>&, float>(),
           "segments"_a.noconvert(), "nodes"_a.noconvert(), "leaves"_a.noconvert(), "refs"_a.noconvert(), "corners"_a,
           "mean_extent"_a);
}

}  // namespace fastlines
