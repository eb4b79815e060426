// The Python modules fastlines_bench._step_timings_*: the time of each step of the kernels, for one instruction set.
#include "step_timings.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>

#include "bindings/arrays.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// The nanoseconds that each step takes alone, by name.
nb::dict time_steps(Input<float> segments, Input<std::uint8_t> nodes, Input<std::uint8_t> leaves,
                    Input<std::uint32_t> refs, std::array<float, 6> corners, Input<float> origins,
                    Input<float> directions, float radius) {
  const Box box{{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
  const Frame frame = frame_of(box);
  const WideBvhView<Segments> tree{.frame = frame,
                                   .box = {frame(box.lo), frame(box.hi)},
                                   .mean_extent = 0.0f,
                                   .nodes = rows<WideNode>(nodes).data(),
                                   .leaves = rows<WideLeaf>(leaves).data(),
                                   .refs = rows<WideRef>(refs).data(),
                                   .items = rows<Segment>(segments).data()};
  const float t_min = 0.0f, t_max = std::numeric_limits<float>::infinity();
  const RayBatch rays{rows<Vec3>(origins), rows<Vec3>(directions), {&radius, 1}, {&t_min, 1}, {&t_max, 1}};
  if (rays.size() < kGroupSize || refs.size() == 0)
    throw std::invalid_argument("steps are timed on 64 rays or more, and a segment or more");
  const StepTimings found = measure_steps(tree, rays);
  nb::dict by_name;
  for (const auto& [name, nanoseconds] :
       std::initializer_list<std::pair<const char*, double>>{{"cycle", found.cycle},
                                                             {"rays", found.ray},
                                                             {"nodes", found.node},
                                                             {"leaves", found.leaf},
                                                             {"segments", found.segment},
                                                             {"lines", found.line},
                                                             {"packets", found.packet},
                                                             {"tests", found.test}})
    by_name[name] = nanoseconds;
  return by_name;
}

}  // namespace
}  // namespace fastlines

NB_MODULE(FASTLINES_MODULE, m) {
  m.def("time_steps", &fastlines::time_steps, "segments"_a.noconvert(), "nodes"_a.noconvert(), "leaves"_a.noconvert(),
        "refs"_a.noconvert(), "box"_a, "origins"_a.noconvert(), "directions"_a.noconvert(), "radius"_a);
}
