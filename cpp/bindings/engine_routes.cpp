// The routes of rays through the tiles of a forest.
#include "engine.hpp"
#include "fastlines/forest/ray_routes.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

RayRoutes ray_routes(const TopTree& top, RayArrays rays, unsigned n_threads, nb::object progress) {
  RayRoutes routes;
  const RayBatch batch = batch_of(rays);
  const bool is_long = may_be_long(batch.size(), top.n_tiles());
  watch_if(is_long, progress,
           [&](Progress& watched) { routes = routes_of(top, batch, is_long ? n_threads : 1, watched); });
  return routes;
}

}  // namespace

void bind_routes(nb::module_& m) {
  m.def("ray_routes", &ray_routes, "top"_a, "rays"_a, "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
