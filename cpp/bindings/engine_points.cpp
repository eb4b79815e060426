// Queries of points on the wide layout.
#include "engine.hpp"
#include "engine/point_queries.hpp"
#include "layout.hpp"
#include "points.hpp"

namespace fastlines {

/// Calls use(search) with the search of a layout.
void with_points(const LayoutView& layout, auto&& use) {
  layout.with_view([&]<class P>(const WideBvhView<P>& view) {
    if constexpr (ProximityPrimitive<P>)
      use(PointSearch<P>(view, layout.leaves.size()));
    else
      throw std::invalid_argument(std::string("queries about points do not know ") + P::kKind);
  });
}

void bind_points(nanobind::module_& m) { bind_points<LayoutView>(m); }

}  // namespace fastlines
