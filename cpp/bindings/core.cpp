// The Python module fastlines._core: the C++ core, and the types of the arguments of the engine modules. Python checks
// all arguments and has all defaults.
#include "core.hpp"

#include "engine/best_simd.hpp"
#include "layout.hpp"
#include "settings.hpp"

NB_MODULE(_core, m) {
  using namespace fastlines;
  nanobind::set_leak_warnings(false);  // trees may outlive the interpreter
  m.doc() = "The C++ core of fastlines. Use the functions of the package; they check what they are given.";
  m.def("best_simd", &best_simd);
  bind_settings(m);
  bind_layout_view(m);
  bind_trees(m);
  bind_checks(m);
  bind_binary_queries(m);
  bind_pairs(m);
  bind_in_box(m);
  bind_merges(m);
  bind_top_tree(m);
  bind_forest(m);
}
