// The frames of hits on axes.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "engine.hpp"
#include "fastlines/query/hit_frames.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Of curves: the control points and the radii, the first piece of each, and the parameter at both ends of each piece.
using CurveArrays =
    std::tuple<Input<float>, std::optional<Input<float>>, Input<std::int64_t>, Input<float>, Input<float>>;
/// Rows of straight axes, and the curves that these stand for.
using AxisArrays = std::tuple<Input<float>, std::optional<CurveArrays>>;
/// Of hits: prim, u, t, and the row of the ray of each, or None for one hit a ray.
using PlaceArrays = std::tuple<Input<std::int64_t>, Input<double>, Input<double>, std::optional<Input<std::int64_t>>>;

/// Of rays: origins, directions, radius, t_min and t_max.
using HitRayArrays = std::tuple<Input<float>, Input<float>, Input<float>, Input<float>, Input<float>>;

RayBatch batch_of(const HitRayArrays& arrays) {
  const auto& [origins, directions, radius, t_min, t_max] = arrays;
  return {rows<Vec3>(origins), rows<Vec3>(directions), rows<float>(radius), rows<float>(t_min), rows<float>(t_max)};
}

/// More hits take longer than starting a thread.
constexpr std::size_t kHitsPerThread = 1 << 14;

/// Axes that do not own their memory.
struct AxesOfArrays : Axes {
  explicit AxesOfArrays(const AxisArrays& arrays) {
    const auto& [straight, of_curves] = arrays;
    rows = fastlines::rows<float>(straight);
    columns = straight.shape(1);
    if (!of_curves) return;
    const auto& [control, radii, first, begin, end] = *of_curves;
    cubic.control = fastlines::rows<CubicCurves::Control>(control);
    if (radii) cubic.radii = fastlines::rows<CubicCurves::Radii>(*radii);
    cubic.first = fastlines::rows<std::int64_t>(first);
    cubic.begin = fastlines::rows<float>(begin);
    cubic.end = fastlines::rows<float>(end);
    curves = &cubic;
  }
  AxesOfArrays(const AxesOfArrays&) = delete;

  CubicCurves cubic;
};

HitPlaces places_of(const PlaceArrays& arrays, bool at_surface) {
  const auto& [prim, u, t, ray] = arrays;
  return {rows<std::int64_t>(prim), rows<double>(u), rows<double>(t),
          ray ? rows<std::int64_t>(*ray) : std::span<const std::int64_t>{}, at_surface};
}

template <class Scalar>
void write_frames(const AxisArrays& arrays, const HitPlaces& places, const RayBatch* rays,
                  const FrameColumns<Scalar>& to, unsigned n_threads, const nb::object& progress) {
  const AxesOfArrays axes(arrays);
  const auto n_workers = unsigned(std::min<std::size_t>(n_threads, places.size() / kHitsPerThread));
  watch_if(n_workers > 1, progress, [&](Progress& watched) {
    if (!places.are_of(axes.size(), rays ? rays->size() : places.size()))
      throw std::out_of_range("these hits name a primitive or a ray that there is not; query again");
    store_frames(HitSource(axes, rays), places, to, std::max(1u, n_workers), watched);
  });
}

template <class Scalar>
typename FrameColumns<Scalar>::Vector* vectors_in(Output<Scalar>& array) {
  return reinterpret_cast<typename FrameColumns<Scalar>::Vector*>(array.data());
}

/// The points on the rays, moved along the normals if a lift is given: one for each hit, or for all.
Output<double> hit_points(AxisArrays axes, PlaceArrays places, HitRayArrays rays, bool surface,
                          std::optional<Input<double>> lift, unsigned n_threads, nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const HitPlaces hits = places_of(places, surface);
  auto found = make_array<double>(hits.size(), 3);
  FrameColumns<double> to;
  to.points = vectors_in(found);
  if (lift) to.lift = rows<double>(*lift);
  if (to.lift.size() > 1 && to.lift.size() != hits.size())
    throw std::invalid_argument("there is not one lift for each hit");
  write_frames(axes, hits, &batch, to, n_threads, progress);
  return found;
}

Output<double> hit_normals(AxisArrays axes, PlaceArrays places, HitRayArrays rays, bool surface, unsigned n_threads,
                           nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const HitPlaces hits = places_of(places, surface);
  auto found = make_array<double>(hits.size(), 3);
  FrameColumns<double> to;
  to.normals = vectors_in(found);
  write_frames(axes, hits, &batch, to, n_threads, progress);
  return found;
}

Output<double> hit_tangents(AxisArrays axes, Input<std::int64_t> prim, Input<double> u, unsigned n_threads,
                            nb::object progress) {
  const HitPlaces places{rows<std::int64_t>(prim), rows<double>(u), {}, {}};
  auto found = make_array<double>(places.size(), 3);
  FrameColumns<double> to;
  to.tangents = vectors_in(found);
  write_frames(axes, places, nullptr, to, n_threads, progress);
  return found;
}

Output<double> hit_radii(AxisArrays axes, Input<std::int64_t> prim, Input<double> u, unsigned n_threads,
                         nb::object progress) {
  const HitPlaces places{rows<std::int64_t>(prim), rows<double>(u), {}, {}};
  auto found = make_array<double>(places.size());
  FrameColumns<double> to;
  to.radius = found.data();
  write_frames(axes, places, nullptr, to, n_threads, progress);
  return found;
}

/// Points, normals, tangents, directions to the eye, and radii for shading.
using FrameTuple = std::tuple<Output<float>, Output<float>, Output<float>, Output<float>, Output<float>>;

FrameTuple hit_frames(AxisArrays axes, PlaceArrays places, HitRayArrays rays, double lift, unsigned n_threads,
                      nb::object progress) {
  const RayBatch batch = batch_of(rays);
  const HitPlaces hits = places_of(places, true);
  const auto array = [&] { return make_array<float>(hits.size(), 3); };
  auto points = array(), normals = array(), tangents = array(), to_eye = array();
  auto radius = make_array<float>(hits.size());
  FrameColumns<float> to{vectors_in(points),
                         vectors_in(normals),
                         vectors_in(tangents),
                         vectors_in(to_eye),
                         radius.data(),
                         {&lift, 1},
                         0.0};
  write_frames(axes, hits, &batch, to, n_threads, progress);
  return {points, normals, tangents, to_eye, radius};
}

/// The curves that pieces are of, and the parameters of places s on them. Misses, -1, stay.
std::tuple<Output<std::int64_t>, Output<float>> on_curves(Input<std::int64_t> piece, Input<float> s,
                                                          Input<std::int64_t> curve, Input<float> begin,
                                                          Input<float> end) {
  const auto pieces = rows<std::int64_t>(piece), curves = rows<std::int64_t>(curve);
  const auto places = rows<float>(s), begins = rows<float>(begin), ends = rows<float>(end);
  auto prim = make_array<std::int64_t>(pieces.size());
  auto u = make_array<float>(pieces.size());
  std::int64_t* const to_prim = prim.data();
  float* const to_u = u.data();
  const WithoutGil without_gil;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const std::int64_t at = pieces[i];
    to_prim[i] = at < 0 ? -1 : curves[std::size_t(at)];
    to_u[i] = at < 0 ? places[i] : parameter_on(begins[std::size_t(at)], ends[std::size_t(at)], places[i]);
  }
  return {prim, u};
}

}  // namespace

void bind_frames(nb::module_& m) {
  m.def("on_curves", &on_curves, "piece"_a, "s"_a, "curve"_a, "begin"_a, "end"_a);
  m.def("hit_points", &hit_points, "axes"_a, "places"_a, "rays"_a.noconvert(), "surface"_a, "lift"_a.none(),
        "n_threads"_a, "progress"_a.none());
  m.def("hit_normals", &hit_normals, "axes"_a, "places"_a, "rays"_a.noconvert(), "surface"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("hit_tangents", &hit_tangents, "axes"_a, "prim"_a, "u"_a, "n_threads"_a, "progress"_a.none());
  m.def("hit_radii", &hit_radii, "axes"_a, "prim"_a, "u"_a, "n_threads"_a, "progress"_a.none());
  m.def("hit_frames", &hit_frames, "axes"_a, "places"_a, "rays"_a.noconvert(), "lift"_a, "n_threads"_a,
        "progress"_a.none());
}

}  // namespace fastlines
