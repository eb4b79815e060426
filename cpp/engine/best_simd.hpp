// The instruction sets that engines are compiled for, and the widest one of this processor. It comes from cpuid: with
// the runtime library of MSVC, __builtin_cpu_supports does not link.
#pragma once

#if defined(__x86_64__)
#include <cpuid.h>
#endif

namespace fastlines {

/// The widest first.
inline constexpr const char* kSimdNames[] = {"avx512", "avx2", "sse42", "neon", "portable"};

/// The name of the widest instruction set that this processor has and that an engine can be compiled for.
inline const char* best_simd() {
#if defined(__x86_64__)
  unsigned eax, ebx, ecx, edx, features, more_features = 0, newer_features = 0, saved = 0;
  if (!__get_cpuid(1, &eax, &ebx, &features, &edx)) return "portable";
  if (__get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx)) more_features = ebx, newer_features = ecx;
  const auto has = [](unsigned word, unsigned bits) { return (word & bits) == bits; };

  // The system must save the wide registers of a thread: XCR0 has bits for SSE and AVX, and three for AVX-512.
  constexpr unsigned avx_state = 0x6, avx512_state = 0xe6;
  if (has(features, bit_OSXSAVE)) __asm__ volatile("xgetbv" : "=a"(saved), "=d"(edx) : "c"(0));
  const bool avx2 =
      has(saved, avx_state) && has(features, bit_FMA) && has(more_features, bit_AVX2 | bit_BMI | bit_BMI2);
  if (avx2 && has(saved, avx512_state) && has(newer_features, bit_AVX512VBMI | bit_AVX512VNNI) &&
      has(more_features, bit_AVX512F | bit_AVX512DQ | bit_AVX512VL | bit_AVX512BW))
    return "avx512";
  if (avx2) return "avx2";
  return has(features, bit_SSE4_2) ? "sse42" : "portable";
#elif defined(__aarch64__)
  return "neon";
#else
  return "portable";
#endif
}

}  // namespace fastlines
