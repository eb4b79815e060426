// Binds the parts of an engine module.
#include "engine.hpp"

#include "fastlines/simd/float_x16.hpp"

namespace fastlines {

void bind_engine(nanobind::module_& m) {
  nanobind::set_leak_warnings(false);  // trees may outlive the interpreter
  m.doc() = "Trees over segments and queries on them, for one instruction set. Use the functions of the package.";
  m.attr("simd") = kSimd;
  bind_build(m);
  bind_layout(m);
  bind_queries(m);
  bind_gather(m);
  bind_points(m);
  bind_pairs(m);
  bind_in_box(m);
  bind_routes(m);
  bind_frames(m);
  bind_hair(m);
  bind_paths(m);
  bind_looks(m);
}

}  // namespace fastlines
