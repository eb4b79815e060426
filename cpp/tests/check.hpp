// The checks of the C++ tests. `run` runs the checks of a program, prints those that fail and returns the exit code.
#pragma once

#include <atomic>
#include <cstdio>
#include <cstring>
#include <source_location>

#include "engine/best_simd.hpp"
#include "fastlines/simd/float_x16.hpp"

namespace fastlines::test {

inline constexpr int kSkipped = 77;  // ctest counts a program with this exit code as skipped
inline std::atomic<int> n_checked = 0, n_failed = 0;

/// Counts a check, and prints its place and text if it fails; only the first failures are printed.
inline void check(bool holds, const char* what, std::source_location at = std::source_location::current()) {
  constexpr int kMaxPrinted = 20;
  ++n_checked;
  if (!holds && n_failed++ < kMaxPrinted) std::printf("%s:%u: failed: %s\n", at.file_name(), at.line(), what);
}

/// Whether this processor has the instruction set that the program is compiled for.
inline bool has_simd() {
  // The first of both names, from the widest, is that of the processor.
  for (const char* name : kSimdNames) {
    if (std::strcmp(name, best_simd()) == 0) return true;
    if (std::strcmp(name, kSimd) == 0) return false;
  }
  return false;
}

/// Runs test() and returns the exit code: 0, 1 if a check failed, kSkipped if the processor lacks the instruction set.
template <class Test>
int run(Test test) {
  if (!has_simd()) {
    std::printf("this processor does not have %s\n", kSimd);
    return kSkipped;
  }
#if defined(FASTLINES_TEST_SIMD)
  check(std::strcmp(kSimd, FASTLINES_TEST_SIMD) == 0, "the program is compiled for " FASTLINES_TEST_SIMD);
#endif
  test();
  check(n_checked > 0, "something is checked");
  std::printf("%s: %d checks, %d failed\n", kSimd, n_checked.load(), n_failed.load());
  return n_failed != 0;
}

}  // namespace fastlines::test
