// The top tree over the tiles of a forest.
#include <nanobind/stl/array.h>

#include "core.hpp"
#include "fastlines/forest/ray_routes.hpp"
#include "layout.hpp"
#include "points.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Lists of tiles as compressed sparse rows.
using TileRows = std::tuple<Output<std::int64_t>, Output<std::int64_t>>;

TopTree top_tree(Input<float> boxes, Input<float> max_radius, const std::array<float, 6>& frame) {
  const auto of = rows<Box>(boxes);
  std::vector<TileBox> tiles;
  for (std::size_t i = 0; i < of.size(); ++i) tiles.push_back({of[i], rows<float>(max_radius)[i]});
  return {tiles, box_of(frame)};
}

/// Offsets, tiles, and where rays enter them.
std::tuple<Output<std::int64_t>, Output<std::int64_t>, Output<float>> arrays_of(const RayRoutes& routes) {
  const std::size_t n = routes.steps.size();
  auto offsets = make_array<std::int64_t>(routes.offsets.size()), tile = make_array<std::int64_t>(n);
  auto enter = make_array<float>(n);
  std::copy(routes.offsets.begin(), routes.offsets.end(), offsets.data());
  for (std::size_t i = 0; i < n; ++i) {
    tile.data()[i] = routes.steps[i].tile;
    enter.data()[i] = routes.steps[i].enter;
  }
  return {offsets, tile, enter};
}

/// A point, as the box that it is alone in.
using Point = double[3];

/// The k tiles that may be nearest to each point, sorted by (distance, tile); −1 at infinity if there are fewer.
std::tuple<Output<double>, Output<std::int64_t>> nearest_tiles(const TopTree& top, Input<double> points, std::size_t k,
                                                               bool surface, unsigned n_threads, nb::object progress) {
  const auto of = rows<std::array<double, 3>>(points);
  auto distance = make_array<double>(of.size(), k);
  auto tile = make_array<std::int64_t>(of.size(), k);
  using Near = std::pair<double, std::int64_t>;
  watch_if(may_be_long(of.size(), top.n_tiles()), progress, [&](Progress& watched) {
    parallel_for_chunks(
        of.size(), 1 << 10, n_threads, watched, [] { return std::vector<Near>(); },
        [&](std::vector<Near>& heap, std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            const Point p = {of[i][0], of[i][1], of[i][2]};
            heap.clear();  // the last one is on top
            top.for_each_near(
                p, p, surface, [&] { return k == 0            ? -kInfinity
                                            : heap.size() < k ? kInfinity
                                                              : heap[0].first; },
                [&](std::uint32_t found, double at) {
                  const Near near{at, found};
                  if (heap.size() == k) {
                    if (!(near < heap[0])) return;
                    std::pop_heap(heap.begin(), heap.end());
                    heap.pop_back();
                  }
                  heap.push_back(near);
                  std::push_heap(heap.begin(), heap.end());
                });
            std::sort(heap.begin(), heap.end());
            heap.resize(k, {kInfinity, -1});
            for (std::size_t j = 0; j < k; ++j) std::tie(distance.data()[i * k + j], tile.data()[i * k + j]) = heap[j];
          }
        });
  });
  return {distance, tile};
}

/// The tiles within limit(i) of the box from low(i) to high(i), in rising order, for n of them.
template <class Low, class High, class Limit>
TileRows near_boxes(const TopTree& top, std::size_t n, bool surface, const Low& low, const High& high,
                    const Limit& limit) {
  LargeVector<std::int64_t> offsets(1), tiles;
  watch_if(may_be_long(n, top.n_tiles()), nb::none(), [&](Progress& watched) {
    for (std::size_t i = 0; i < n; ++i) {
      if (i % 1024 == 0) watched.check();
      const auto a = low(i), b = high(i);
      const Point from = {a[0], a[1], a[2]}, to = {b[0], b[1], b[2]};
      const double within = limit(i);
      top.for_each_near(
          from, to, surface, [&] { return within; }, [&](std::uint32_t tile, double) { tiles.push_back(tile); });
      std::sort(tiles.begin() + offsets.back(), tiles.end());
      offsets.push_back(std::int64_t(tiles.size()));
    }
  });
  return {adopt<std::int64_t>(std::move(offsets)), adopt<std::int64_t>(std::move(tiles))};
}

TileRows tiles_within(const TopTree& top, Input<double> points, Input<float> radius, bool surface) {
  const auto of = rows<std::array<double, 3>>(points);
  const auto point = [&](std::size_t i) { return of[i]; };
  const auto limit = [&](std::size_t i) { return RayBatch::value_of(rows<float>(radius), i); };
  return near_boxes(top, of.size(), surface, point, point, limit);
}

TileRows tiles_in_boxes(const TopTree& top, Input<double> low, Input<double> high, bool surface) {
  const auto from = rows<std::array<double, 3>>(low), to = rows<std::array<double, 3>>(high);
  return near_boxes(
      top, from.size(), surface, [&](std::size_t i) { return from[i]; }, [&](std::size_t i) { return to[i]; },
      [](std::size_t) { return 0.0; });
}

}  // namespace

void bind_top_tree(nb::module_& m) {
  nb::class_<RayRoutes>(m, "RayRoutes").def("arrays", &arrays_of).def_prop_ro("n_steps", [](const RayRoutes& routes) {
    return routes.steps.size();
  });
  nb::class_<TopTree>(m, "TopTree")
      .def(
          "__init__",
          [](TopTree* self, Input<float> boxes, Input<float> max_radius, const std::array<float, 6>& frame) {
            new (self) TopTree(top_tree(boxes, max_radius, frame));
          },
          "boxes"_a.noconvert(), "max_radius"_a.noconvert(), "frame"_a)
      .def("nearest_tiles", &nearest_tiles, "points"_a, "k"_a, "surface"_a, "n_threads"_a, "progress"_a.none())
      .def("tiles_within", &tiles_within, "points"_a, "radius"_a, "surface"_a)
      .def("tiles_in_boxes", &tiles_in_boxes, "low"_a, "high"_a, "surface"_a);
}

}  // namespace fastlines
