// Regions of interest by brute force.
#include "core.hpp"
#include "fastlines/primitives/point_test.hpp"
#include "in_box.hpp"
#include "primitives.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

InBoxTuple in_box(const std::string& kind, Input<float> data, Input<double> low, Input<double> high, bool surface,
                  unsigned n_threads, nb::object progress) {
  return std::visit(
      [&]<class P>(const P& prims) -> InBoxTuple {
        if constexpr (ProximityPrimitive<P>)
          return in_boxes(low, high, prims.size(), prims.size(), n_threads, progress,
                          [&] { return BruteForceInBox<P>{prims, surface}; });
        else
          throw std::invalid_argument(std::string("queries about regions do not know ") + P::kKind);
      },
      ray_primitives(kind, data));
}

}  // namespace

void bind_in_box(nb::module_& m) {
  m.def("in_box", &in_box, "kind"_a, "data"_a.noconvert(), "low"_a.noconvert(), "high"_a.noconvert(), "surface"_a,
        "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
