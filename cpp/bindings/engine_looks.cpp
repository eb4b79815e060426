// What looks are made of: fragments of thin lines, smooth directions, the density of lines, and light.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include "arrays.hpp"
#include "engine.hpp"
#include "fastlines/shading/cone_fragments.hpp"
#include "fastlines/shading/density_grid.hpp"
#include "fastlines/shading/hair_light.hpp"
#include "fastlines/shading/interpolation.hpp"
#include "fastlines/shading/smooth_tangents.hpp"
#include "fastlines/shading/sobol.hpp"
#include "fastlines/shading/solid_light.hpp"
#include "shading.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

Vec3Lanes vectors(const Input<float>& from, std::size_t first, int n) {
  return Vec3Lanes::load(from.data() + 3 * first, n);
}

// --- Fragments ---

/// Hits of rays: offsets, the row of each hit's axis, t, u, the distance, and the radius of the line or none.
using ConeHitArrays = std::tuple<Input<std::int64_t>, Input<std::int64_t>, Input<float>, Input<float>, Input<float>,
                                 std::optional<Input<float>>>;
/// Fragments: their hits, their rays and their weights; and the opacity of each ray.
using FragmentTuple = std::tuple<Output<std::int64_t>, Output<std::int64_t>, Output<float>, Output<float>>;

FragmentTuple fragments_of(ConeHitArrays hit_arrays, Input<float> origins, Input<float> directions, Input<float> axes,
                           std::array<float, 4> settings, Input<float> chances) {
  const auto& [offsets, axis, t, u, distance, own_radius] = hit_arrays;
  const ConeHits hits{rows<std::int64_t>(offsets),
                      rows<std::int64_t>(axis),
                      rows<float>(t),
                      rows<float>(u),
                      rows<float>(distance),
                      own_radius ? rows<float>(*own_radius) : std::span<const float>{},
                      rows<Vec3>(origins),
                      rows<Vec3>(directions)};
  const AxisPoints points{rows<Vec3>(axes), axes.shape(1)};
  auto opacity = make_array<float>(hits.directions.size());
  ConeFragments found;
  {
    const WithoutGil without_gil;
    found = cone_fragments(hits, points, {settings[0], settings[1], settings[2], settings[3]}, rows<float>(chances),
                           {opacity.data(), opacity.size()});
  }
  return {adopt<std::int64_t>(std::move(found.hit)), adopt<std::int64_t>(std::move(found.ray)),
          adopt<float>(std::move(found.weight)), opacity};
}

Output<float> smooth_tangents(Input<float> segments, Input<std::int64_t> strands, Input<std::int64_t> prim,
                              Input<float> u, Input<float> tangents) {
  auto found = make_array<float>(prim.size(), 3);
  const WithoutGil without_gil;
  const StrandSegments lines{rows<std::array<Vec3, 2>>(segments), rows<std::int64_t>(strands)};
  const auto own = rows<Vec3>(tangents);
  const std::span<Vec3> smooth(reinterpret_cast<Vec3*>(found.data()), prim.size());
  for (std::size_t i = 0; i < prim.size(); ++i)
    smooth[i] = lines.smooth_tangent(std::size_t(prim.data()[i]), u.data()[i], own[i]);
  return found;
}

/// numpy.interp of places that rise from 0 to 1, as float32.
Output<float> interpolated(Input<float> x, Input<double> places, Input<double> values) {
  auto found = make_array<float>(x.size());
  const WithoutGil without_gil;
  const Interpolation function(rows<double>(places), rows<double>(values));
  for (std::size_t i = 0; i < x.size(); ++i) found.data()[i] = float(function(double(x.data()[i])));
  return found;
}

// --- The density of lines ---

/// The low and the high corner of a box, and the numbers of its voxels.
using BoxTuple = std::tuple<Corners, Counts>;

VoxelBox voxel_box(const BoxTuple& box) { return {box_of(std::get<0>(box)), std::get<1>(box)}; }

std::span<const LineTensor> tensors_of(const Input<float>& array) { return rows<LineTensor>(array); }
std::span<LineTensor> tensors_of(Output<float>& array) {
  return {reinterpret_cast<LineTensor*>(array.data()), array.shape(0)};
}

/// The tensors of lines in voxels, and in blocks of voxels.
std::tuple<Output<float>, Output<float>> density_grid(Input<float> axes, Input<float> end_radii, float radius,
                                                      BoxTuple box, unsigned n_threads, nb::object progress) {
  const VoxelBox voxels = voxel_box(box);
  auto fine = make_array<float>(voxels.size(), 6), coarse = make_array<float>(DensityGrid::blocks_of(voxels).size(), 6);
  const ThickLines lines{rows<std::array<Vec3, 2>>(axes), rows<std::array<float, 2>>(end_radii), radius};
  watch(
      [&](Progress& watched) {
        const std::span<LineTensor> tensors = tensors_of(fine);
        std::fill(tensors.begin(), tensors.end(), LineTensor{});
        add_lines(lines, voxels, tensors, n_threads, watched);
        DensityGrid::average(voxels, tensors, tensors_of(coarse));
      },
      progress);
  return {fine, coarse};
}

/// The optical depth on the way of light to points of lines, and the part of it that is far.
std::tuple<Output<float>, Output<float>> optical_depth(BoxTuple box, Input<float> voxels, Input<float> blocks,
                                                       Input<float> points, Input<float> tangents, Input<float> towards,
                                                       Input<float> jitter, float radius, float far, float end) {
  const std::size_t n_rows = points.shape(0);
  auto all = make_array<float>(n_rows), far_ones = make_array<float>(n_rows);
  const DensityGrid grid(voxel_box(box), tensors_of(voxels), tensors_of(blocks));
  in_lanes(n_rows, [&](std::size_t first, int n) {
    const auto found = grid.optical_depth(vectors(points, first, n), vectors(tangents, first, n),
                                          vectors(towards, first, n), radius, far, end, vectors(jitter, first, n));
    store_lanes(found.all, all.data() + first, n);
    store_lanes(found.far, far_ones.data() + first, n);
  });
  return {all, far_ones};
}

/// The light that passes opaque lines which it crosses so often on average.
Output<float> attenuated(Input<float> light, Input<float> crossed) {
  const std::size_t n_rows = crossed.size();
  auto found = make_array<float>(n_rows, 3);
  in_lanes(n_rows, [&](std::size_t first, int n) {
    (exp(-load_lanes(crossed.data() + first, n)) * vectors(light, first, n)).store(found.data() + 3 * first, n);
  });
  return found;
}

// --- Light ---

/// The index of a sample, the seeds of its fragments, and the dimension of the next numbers.
using NumbersTuple = std::tuple<std::uint32_t, Input<std::uint32_t>, int>;

/// One direction to each lamp, (n_lamps · n, 3); one of the sky, and its radiance there; and three numbers for jitter.
std::tuple<Output<float>, Output<float>, Output<float>, Output<float>> light_samples(Input<float> lamps, SkyNumbers sky,
                                                                                     NumbersTuple numbers) {
  const auto& [index, seeds, dimension] = numbers;
  const auto each_lamp = rows<DistantLight>(lamps);
  const SkyLight of_sky = sky_of(sky);
  const std::size_t n = seeds.size();
  auto to_lamps = make_array<float>(each_lamp.size() * n, 3), to_sky = make_array<float>(n, 3);
  auto radiance = make_array<float>(n, 3), jitter = make_array<float>(n, 3);
  in_lanes(n, [&, index = index, dimension = dimension](std::size_t first, int count) {
    const WordLanes own = load_lanes(seeds.data() + first, count);
    int next = dimension;
    const auto pair = [&](auto&& use) {
      use(uniforms(index, own, next), uniforms(index, own, next + 1));
      next += 2;
    };
    for (std::size_t lamp = 0; lamp < each_lamp.size(); ++lamp)
      pair([&](const FloatLanes& u, const FloatLanes& v) {
        each_lamp[lamp].sample(u, v).store(to_lamps.data() + 3 * (lamp * n + first), count);
      });
    pair([&](const FloatLanes& u, const FloatLanes& v) {
      const Vec3Lanes towards = sphere(u, v);
      towards.store(to_sky.data() + 3 * first, count);
      of_sky.radiance(towards).store(radiance.data() + 3 * first, count);
    });
    Vec3Lanes{uniforms(index, own, next), uniforms(index, own, next + 1), uniforms(index, own, next + 2)}.store(
        jitter.data() + 3 * first, count);
  });
  return {to_lamps, to_sky, radiance, jitter};
}

/// The numbers of a material, and the tables of its far field.
using HairArrays = std::tuple<HairNumbers, Input<float>, Input<float>>;
/// Unit axes, and unit directions to the eye.
using DirectionArrays = std::tuple<Input<float>, Input<float>>;
/// Unit directions to a light, its irradiance or that of each direction, and how many hairs it crosses: all, and far.
using ArrivingArrays = std::tuple<Input<float>, Input<float>, Input<float>, Input<float>>;

/// The light of hairs from one direction each.
Output<float> light_of_hair(HairArrays hair, DirectionArrays axes, ArrivingArrays light, bool is_sharp, float density) {
  const auto& [numbers, azimuths, inclinations] = hair;
  const auto& [tangents, to_eye] = axes;
  const auto& [towards, color, crossed, far] = light;
  const HairMaterial material(numbers);
  const HairTable table = table_of(material, azimuths, inclinations);
  const std::size_t n_rows = crossed.size();
  auto found = make_array<float>(n_rows, 3);
  const bool is_one = color.size() == 3;
  const Vec3Lanes one_color = is_one ? Vec3Lanes{color.data()[0], color.data()[1], color.data()[2]} : Vec3Lanes{};
  in_lanes(n_rows, [&, &tangents = tangents, &to_eye = to_eye, &towards = towards, &color = color, &crossed = crossed,
                    &far = far](std::size_t first, int n) {
    const ArrivingLight arriving{vectors(towards, first, n), is_one ? one_color : vectors(color, first, n),
                                 load_lanes(crossed.data() + first, n), load_lanes(far.data() + first, n)};
    hair_light(table, vectors(tangents, first, n), vectors(to_eye, first, n), arriving, is_sharp, density)
        .store(found.data() + 3 * first, n);
  });
  return found;
}

/// Directions and what light brings from there if nothing hides it.
using UnhiddenTuple = std::tuple<Output<float>, Output<float>>;

/// The light of one lamp for each fragment, and that of one direction of the sky; and three numbers for jitter if lines
/// are thin. Otherwise axes are normals.
std::tuple<UnhiddenTuple, UnhiddenTuple, Output<float>> light_of_solids(DirectionArrays axes, Input<float> base,
                                                                        bool is_thin, std::array<float, 4> material,
                                                                        Input<float> lamps, SkyNumbers sky,
                                                                        NumbersTuple numbers) {
  const auto& [along, to_eye] = axes;
  const auto& [index, seeds, dimension] = numbers;
  const std::size_t n_rows = seeds.size();
  const auto each_lamp = rows<DistantLight>(lamps);
  const SkyLight of_all_sky = sky_of(sky);
  const SolidMaterial solid{material[0], material[1], material[2], material[3]};
  const auto make = [&] { return UnhiddenTuple{make_array<float>(n_rows, 3), make_array<float>(n_rows, 3)}; };
  UnhiddenTuple of_lamps = make(), from_sky = make();
  auto jitter = make_array<float>(is_thin ? n_rows : 0, 3);
  const auto store = [](const UnhiddenLight& found, UnhiddenTuple& to, std::size_t first, int n) {
    found.towards.store(std::get<0>(to).data() + 3 * first, n);
    found.light.store(std::get<1>(to).data() + 3 * first, n);
  };
  in_lanes(n_rows, [&, index = index, dimension = dimension, &along = along, &to_eye = to_eye, &seeds = seeds](
                       std::size_t first, int n) {
    const SolidPoints points{vectors(along, first, n), vectors(to_eye, first, n), vectors(base, first, n), is_thin};
    const WordLanes own = load_lanes(seeds.data() + first, n);
    const auto number = [&](int next) { return uniforms(index, own, dimension + next); };
    store(one_lamp(points, solid, each_lamp, number(0), number(1), number(2)), of_lamps, first, n);
    store(of_sky(points, of_all_sky, number(4), number(5)), from_sky, first, n);
    if (is_thin) Vec3Lanes{number(6), number(7), number(8)}.store(jitter.data() + 3 * first, n);
  });
  return {of_lamps, from_sky, jitter};
}

}  // namespace

void bind_looks(nb::module_& m) {
  m.def("cone_fragments", &fragments_of, "hits"_a, "origins"_a.noconvert(), "directions"_a.noconvert(),
        "axes"_a.noconvert(), "settings"_a, "chances"_a.noconvert());
  m.def("smooth_tangents", &smooth_tangents, "segments"_a.noconvert(), "strands"_a.noconvert(), "prim"_a.noconvert(),
        "u"_a.noconvert(), "tangents"_a.noconvert());
  m.def("interpolated", &interpolated, "x"_a.noconvert(), "places"_a.noconvert(), "values"_a.noconvert());
  m.def("density_grid", &density_grid, "axes"_a.noconvert(), "end_radii"_a.noconvert(), "radius"_a, "box"_a,
        "n_threads"_a, "progress"_a.none());
  m.def("optical_depth", &optical_depth, "box"_a, "voxels"_a.noconvert(), "blocks"_a.noconvert(),
        "points"_a.noconvert(), "tangents"_a.noconvert(), "towards"_a.noconvert(), "jitter"_a.noconvert(), "radius"_a,
        "far"_a, "end"_a);
  m.def("attenuated", &attenuated, "light"_a.noconvert(), "crossed"_a.noconvert());
  m.def("light_samples", &light_samples, "lamps"_a.noconvert(), "sky"_a, "numbers"_a);
  m.def("light_of_hair", &light_of_hair, "hair"_a, "axes"_a, "light"_a, "is_sharp"_a, "density"_a);
  m.def("light_of_solids", &light_of_solids, "axes"_a, "base"_a.noconvert(), "is_thin"_a, "material"_a,
        "lamps"_a.noconvert(), "sky"_a, "numbers"_a);
}

}  // namespace fastlines
