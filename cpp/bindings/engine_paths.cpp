// Random numbers of samples, and the bounces of path tracing.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "engine.hpp"
#include "fastlines/shading/paths.hpp"
#include "shading.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// An array that a function changes.
template <class Scalar>
using Changed = nb::ndarray<Scalar, nb::c_contig, nb::device::cpu>;

/// Some consecutive dimensions of a sample, one array of each.
std::vector<Output<float>> sample_numbers(std::uint32_t index, Input<std::uint32_t> seeds, int dimension, int count) {
  const std::size_t n = seeds.size();
  std::vector<Output<float>> made;
  for (int k = 0; k < count; ++k) made.push_back(make_array<float>(n));
  in_lanes(n, [&](std::size_t first, int filled) {
    const WordLanes some = load_lanes(seeds.data() + first, filled);
    for (int k = 0; k < count; ++k)
      store_lanes(uniforms(index, some, dimension + k), made[std::size_t(k)].data() + first, filled);
  });
  return made;
}

/// The columns of vertices: points, normals, tangents, directions towards the eye, and radii.
using VertexArrays = std::tuple<Input<float>, Input<float>, Input<float>, Input<float>, Input<float>>;
/// The path of each vertex, its weight, and the seeds of all paths.
using PathArrays = std::tuple<Input<std::int64_t>, Input<float>, Input<std::uint32_t>>;
/// Lights, the numbers of the fibres, the reflectance of other surfaces, and where rays start at least.
using SceneArrays = std::tuple<Input<float>, HairNumbers, std::array<float, 3>, float>;
/// The index of the sample, the dimension of its next numbers, and the number of the bounce.
using StepTuple = std::tuple<std::uint32_t, int, int>;
/// Rays: the vertex that each leaves, its point, direction and start, and what it brings.
using RayTuple = std::tuple<Output<std::int64_t>, Output<float>, Output<float>, Output<float>, Output<float>>;

RayTuple arrays_of(LeavingRays& rays) {
  return {adopt<std::int64_t>(std::move(rays.vertex)), adopt<float>(std::move(rays.points)),
          adopt<float>(std::move(rays.directions)), adopt<float>(std::move(rays.start)),
          adopt<float>(std::move(rays.value))};
}

/// Scatter light at all vertices of one bounce.
std::tuple<std::vector<RayTuple>, RayTuple, int> scatter_paths(SceneArrays scene_arrays, StepTuple step,
                                                               VertexArrays vertex_arrays, PathArrays path_arrays) {
  const auto& [lights, hair, skin, least_start] = scene_arrays;
  const auto& [points, normals, tangents, to_eye, radius] = vertex_arrays;
  const auto& [path, weight, seeds] = path_arrays;
  const PathScene scene{rows<DistantLight>(lights), HairMaterial(hair), {skin[0], skin[1], skin[2]}, least_start};
  const auto& [index, dimension, number] = step;
  const PathVertexRows vertices{points.data(), normals.data(), tangents.data(),
                                to_eye.data(), radius.data(),  radius.size()};
  PathBounce bounce = [&] {
    const WithoutGil released;
    return PathBounce(scene, {index, dimension, number}, vertices, {path.data(), weight.data(), seeds.data()});
  }();
  std::vector<RayTuple> shadows;
  for (LeavingRays& rays : bounce.shadows) shadows.push_back(arrays_of(rays));
  return {shadows, arrays_of(bounce.onward), bounce.dimension};
}

/// Add what rays to a light bring to the light of their paths, where nothing hides it.
void add_offered(Changed<float> light, Input<std::int64_t> path, Input<std::int64_t> vertex, Input<float> offered,
                 Input<bool> free) {
  const WithoutGil released;
  for (std::size_t i = 0; i < vertex.size(); ++i)
    if (free.data()[i])
      for (int c = 0; c < 3; ++c) light.data()[3 * path.data()[vertex.data()[i]] + c] += offered.data()[3 * i + c];
}

/// Add the light of the sky to that of paths whose rays leave the scene.
void add_sky(Changed<float> light, Input<std::int64_t> path, Input<float> weight, Input<float> directions,
             Input<bool> away, SkyNumbers numbers) {
  const SkyLight sky = sky_of(numbers);
  in_lanes(path.size(), [&](std::size_t i, int count) {
    float brought[3 * kLanes];
    const Vec3Lanes each = Vec3Lanes::load(weight.data() + 3 * i, count);
    (each * sky.radiance(Vec3Lanes::load(directions.data() + 3 * i, count))).store(brought, count);
    for (int k = 0; k < count; ++k)
      if (away.data()[i + k])
        for (int c = 0; c < 3; ++c) light.data()[3 * path.data()[i + k] + c] += brought[3 * k + c];
  });
}

}  // namespace

void bind_paths(nb::module_& m) {
  m.def("sample_numbers", &sample_numbers, "index"_a, "seeds"_a.noconvert(), "dimension"_a, "count"_a);
  m.def("scatter_paths", &scatter_paths, "scene"_a, "step"_a, "vertices"_a, "paths"_a);
  m.def("add_offered", &add_offered, "light"_a.noconvert(), "path"_a.noconvert(), "vertex"_a.noconvert(),
        "offered"_a.noconvert(), "free"_a.noconvert());
  m.def("add_sky", &add_sky, "light"_a.noconvert(), "path"_a.noconvert(), "weight"_a.noconvert(),
        "directions"_a.noconvert(), "away"_a.noconvert(), "sky"_a);
}

}  // namespace fastlines
