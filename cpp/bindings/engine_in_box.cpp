// Regions of interest on the wide layout.
#include "engine.hpp"
#include "fastlines/kernels/proximity/in_box.hpp"
#include "fastlines/primitives/point_test.hpp"
#include "in_box.hpp"
#include "layout.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

InBoxTuple in_box(const LayoutView& layout, Input<double> low, Input<double> high, bool surface, unsigned n_threads,
                  nb::object progress) {
  const std::size_t n_prims = std::visit([](const auto& prims) { return prims.size(); }, layout.prims);
  return layout.with_view([&]<class P>(const WideBvhView<P>& view) -> InBoxTuple {
    if constexpr (ProximityPrimitive<P>)
      return in_boxes(low, high, n_prims, layout.leaves.size(), n_threads, progress,
                      [&] { return InBoxSearch<P>(view, surface); });
    else
      throw std::invalid_argument(std::string("queries about regions do not know ") + P::kKind);
  });
}

}  // namespace

void bind_in_box(nb::module_& m) {
  m.def("in_box", &in_box, "layout"_a, "low"_a.noconvert(), "high"_a.noconvert(), "surface"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
