// The Python module fastlines._core: the C++ core, and the types of the arguments of the engine modules. Python checks
// all arguments and has all defaults.
#include "core.hpp"

#include "layout.hpp"
#include "settings.hpp"

namespace fastlines {
namespace {

/// The name of the widest instruction set that this processor has and that an engine module can be compiled for.
const char* best_simd() {
#if defined(__x86_64__) || defined(__i386__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                    __builtin_cpu_supports("bmi2");
  if (avx2 && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vbmi") &&
      __builtin_cpu_supports("avx512vnni"))
    return "avx512";
  if (avx2) return "avx2";
  if (__builtin_cpu_supports("sse4.2")) return "sse42";
  return "portable";
#elif defined(__aarch64__)
  return "neon";
#else
  return "portable";
#endif
}

}  // namespace
}  // namespace fastlines

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
}
