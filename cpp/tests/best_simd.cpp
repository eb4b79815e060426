// The instruction set that the Python package picks: the compiler's own detection agrees with it.
#include "engine/best_simd.hpp"

#include <cstring>

#include "check.hpp"

using namespace fastlines;

int main() {
  return test::run([] {
    const char* expected = "portable";
#if defined(__x86_64__)
    if (__builtin_cpu_supports("sse4.2")) expected = "sse42";
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
        __builtin_cpu_supports("bmi2")) {
      expected = "avx2";
      if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
          __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vbmi") &&
          __builtin_cpu_supports("avx512vnni"))
        expected = "avx512";
    }
#elif defined(__aarch64__)
    expected = "neon";
#endif
    test::check(std::strcmp(best_simd(), expected) == 0, "cpuid and the compiler agree");
  });
}
