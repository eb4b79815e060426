// The instruction sets that engines are compiled for, and the widest one of this processor.
#pragma once

namespace fastlines {

/// The widest first.
inline constexpr const char* kSimdNames[] = {"avx512", "avx2", "sse42", "neon", "portable"};

/// The name of the widest instruction set that this processor has and that an engine can be compiled for.
inline const char* best_simd() {
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

}  // namespace fastlines
