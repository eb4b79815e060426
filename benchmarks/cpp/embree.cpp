// The Python module fastlines_bench._embree: Embree as a peer to compare with. Python checks all arguments
// (fastlines_bench/peers/embree.py).
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <stdexcept>

#include "bindings/arrays.hpp"
#include "bindings/gil.hpp"
#include "embree_trace.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines::peers {
namespace {

/// The widest instruction set of this processor that callbacks are compiled for; "" on an x86 without AVX2.
std::string instruction_set() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) return "avx512";
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "avx2";
  return "";
#else
  return "portable";
#endif
}

Callbacks best_callbacks() {
#if defined(__x86_64__)
  return instruction_set() == "avx512" ? avx512::callbacks() : avx2::callbacks();
#else
  return portable::callbacks();
#endif
}

/// Loads Embree and returns its version.
std::tuple<int, int, int> load(const std::string& tbb, const std::string& embree) {
  const Api& rtc = load_api(tbb, embree);
  const Device device = rtc.NewDevice("threads=1");
  if (!device) throw std::runtime_error("Embree gives no device");
  const auto get = [&](int property) { return int(rtc.GetDeviceProperty(device, property)); };
  const std::tuple version{get(kVersionMajor), get(kVersionMinor), get(kVersionPatch)};
  rtc.ReleaseDevice(device);
  return version;
}

Kind kind_named(const std::string& name) {
  if (name == "user") return Kind::user;
  if (name == "flat") return Kind::flat;
  if (name == "round") return Kind::round;
  if (name == "ribbon") return Kind::ribbon;
  if (name == "bezier") return Kind::bezier;
  if (name == "sphere") return Kind::sphere;
  if (name == "triangle") return Kind::triangle;
  throw std::invalid_argument("unknown kind of geometry: " + name);
}

Quality quality_named(const std::string& name) {
  if (name == "low") return Quality::low;
  if (name == "medium") return Quality::medium;
  if (name == "high") return Quality::high;
  throw std::invalid_argument("unknown quality: " + name);
}

void make_scene(Scene* self, Input<float> segments, Input<float> radii, Input<float> vertices,
                Input<std::uint32_t> index, const std::string& kind, float radius, float piece_length,
                unsigned halvings, const std::string& quality, bool compact, const std::string& device,
                std::tuple<float, float, float> eye) {
  SceneSettings settings;
  settings.kind = kind_named(kind);
  settings.radius = radius;
  settings.piece_length = piece_length;
  settings.halvings = halvings;
  settings.quality = quality_named(quality);
  settings.compact = compact;
  settings.device = device;
  std::tie(settings.eye[0], settings.eye[1], settings.eye[2]) = eye;
  const SceneInput input{rows<SegmentEnds>(segments), rows<float>(radii), rows<float>(vertices),
                         rows<std::uint32_t>(index)};
  const WithoutGil without_gil;
  new (self) Scene(input, settings, best_callbacks());
}

Rays batch(const Input<float>& origins, const Input<float>& directions, float t_min, float t_max) {
  return {rows<Ray3>(origins), rows<Ray3>(directions), t_min, t_max};
}

nb::tuple first_hit(const Scene& scene, Input<float> origins, Input<float> directions, float t_min, float t_max,
                    int width, bool coherent, unsigned n_threads) {
  const Rays rays = batch(origins, directions, t_min, t_max);
  auto t = make_array<float>(rays.origins.size());
  auto prim = make_array<std::int32_t>(rays.origins.size());
  {
    const WithoutGil without_gil;
    first_hits(scene, rays, {width, coherent, n_threads}, t.data(), prim.data());
  }
  return nb::make_tuple(t, prim);
}

Output<bool> any_hit(const Scene& scene, Input<float> origins, Input<float> directions, float t_min, float t_max,
                     int width, bool coherent, unsigned n_threads) {
  const Rays rays = batch(origins, directions, t_min, t_max);
  auto found = make_array<bool>(rays.origins.size());
  const WithoutGil without_gil;
  any_hits(scene, rays, {width, coherent, n_threads}, found.data());
  return found;
}

/// The sums of each ray; `gather` has the fields of Gather without the bounds of t.
Output<float> gather(const Scene& scene, Input<float> origins, Input<float> directions, float t_min, float t_max,
                     int width, bool coherent, unsigned n_threads, std::tuple<float, float, float, float> gather,
                     Input<float> powers) {
  const Rays rays = batch(origins, directions, t_min, t_max);
  const auto [radius, sigma, line_sigma, g] = gather;
  auto sums = make_array<float>(kColours * rays.origins.size());
  const WithoutGil without_gil;
  gathers(scene, rays, {width, coherent, n_threads}, {radius, sigma, line_sigma, g, t_min, t_max},
          rows<float>(powers).data(), best_callbacks(), sums.data());
  return sums;
}

/// The hits of each thread.
struct HitBuffers {
  std::vector<HitBuffer> threads;

  explicit HitBuffers(std::vector<HitBuffer> hits) : threads(std::move(hits)) {}
  HitBuffers(HitBuffers&&) = default;  // not copyable
};

/// All hits as the callbacks wrote them, to be unpacked outside the timed section.
HitBuffers all_hit(const Scene& scene, Input<float> origins, Input<float> directions, float t_min, float t_max,
                   int width, bool coherent, unsigned n_threads) {
  const Rays rays = batch(origins, directions, t_min, t_max);
  const WithoutGil without_gil;
  return HitBuffers(all_hits(scene, rays, {width, coherent, n_threads}, best_callbacks()));
}

/// The columns ray, prim and t of the hits, in no order.
nb::tuple unpack(const HitBuffers& buffers) {
  std::size_t n = 0, i = 0;
  for (const HitBuffer& hits : buffers.threads) n += std::size_t(hits.at - hits.begin);
  auto ray = make_array<std::int64_t>(n);
  auto prim = make_array<std::int64_t>(n);
  auto t = make_array<float>(n);
  for (const HitBuffer& hits : buffers.threads)
    for (const PeerHit* hit = hits.begin; hit != hits.at; ++hit) {
      ray.data()[i] = hit->ray;
      prim.data()[i] = hit->prim;
      t.data()[i++] = hit->t;
    }
  return nb::make_tuple(ray, prim, t);
}

}  // namespace
}  // namespace fastlines::peers

NB_MODULE(_embree, m) {
  using namespace fastlines;
  using namespace fastlines::peers;
  m.doc() = "Embree, loaded at run time. Use fastlines_bench.peers.embree, which checks what it is given.";
  m.def("instruction_set", &instruction_set);
  m.def("load", &load, "tbb"_a, "embree"_a);
  nb::class_<HitBuffers>(m, "HitBuffers").def("unpack", &unpack);
  const auto query = [](auto& scene, const char* name, auto function) {
    scene.def(name, function, "origins"_a.noconvert(), "directions"_a.noconvert(), "t_min"_a, "t_max"_a, "width"_a,
              "coherent"_a, "n_threads"_a);
  };
  nb::class_<Scene> scene(m, "Scene");
  scene.def("__init__", &make_scene, "segments"_a.noconvert(), "radii"_a.noconvert(), "vertices"_a.noconvert(),
            "index"_a.noconvert(), "kind"_a, "radius"_a, "piece_length"_a, "halvings"_a, "quality"_a, "compact"_a,
            "device"_a, "eye"_a);
  query(scene, "first_hit", &first_hit);
  query(scene, "any_hit", &any_hit);
  query(scene, "all_hits", &all_hit);
  scene.def("gather", &gather, "origins"_a.noconvert(), "directions"_a.noconvert(), "t_min"_a, "t_max"_a, "width"_a,
            "coherent"_a, "n_threads"_a, "gather"_a, "powers"_a.noconvert());
  scene.def("is_native", &Scene::is_native, "width"_a);
  scene.def_rw("radius", &Scene::radius);
  scene.def_prop_ro("n_pieces", &Scene::n_pieces);
  scene.def_prop_ro("bytes", &Scene::bytes);
}
