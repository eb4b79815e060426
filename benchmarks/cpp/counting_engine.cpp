// The Python module fastlines_bench._counting: queries on segments that count their steps; they must run on one thread.
#include <utility>

#include "bindings/engine.hpp"
#include "fastlines/kernels/cost/step_counters.hpp"

namespace nb = nanobind;

namespace fastlines {
namespace {

/// The number of steps since the last call, by name; see kernels/cost/step_counters.hpp.
nb::dict take_steps() {
  const StepCounters now = std::exchange(steps, StepCounters{});
  nb::dict found;
  for (const auto& [name, n] : std::initializer_list<std::pair<const char*, std::uint64_t>>{{"rays", now.rays},
                                                                                            {"bundles", now.bundles},
                                                                                            {"nodes", now.nodes},
                                                                                            {"leaves", now.leaves},
                                                                                            {"pieces", now.pieces},
                                                                                            {"segments", now.segments},
                                                                                            {"lines", now.lines},
                                                                                            {"packets", now.packets},
                                                                                            {"tests", now.tests}})
    found[name] = n;
  return found;
}

}  // namespace
}  // namespace fastlines

NB_MODULE(_counting, m) {
  fastlines::bind_queries(m);
  m.def("take_steps", &fastlines::take_steps);
}
