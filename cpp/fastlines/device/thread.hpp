// A kernel, and the number of its thread: on a GPU, or in a loop on the host.
//
// The text of the kernels is the same for both, and is compiled without a toolkit: on a GPU by NVRTC at run time, on
// the host by any C++20 compiler, for the tests. NVRTC has no headers of the standard library; a few names of <array>,
// <cmath> and others come from src/fastlines/cuda/std. It takes functions without a mark for device functions
// (-default-device), so no header needs one.
#pragma once

#include <cstdint>

#if defined(__CUDACC__)

#if !defined(FASTLINES_BLOCK)
/// Threads of a block.
#define FASTLINES_BLOCK 128
#endif

#define FASTLINES_KERNEL extern "C" __global__ void __launch_bounds__(FASTLINES_BLOCK)
#define FASTLINES_UNROLL _Pragma("unroll")
#define FASTLINES_NO_UNROLL _Pragma("unroll 1")

namespace fastlines {

/// The number of the calling thread.
inline std::uint64_t thread_index() { return std::uint64_t(blockIdx.x) * blockDim.x + threadIdx.x; }

/// The lowest bit of a mask that has one.
inline int lowest_bit(std::uint32_t mask) { return __ffs(int(mask)) - 1; }

/// The number of bits of a mask.
inline int count_bits(std::uint32_t mask) { return __popc(mask); }

/// Add one to a number that all threads share.
inline void add_one(std::uint32_t* number) { atomicAdd(number, 1u); }

/// For tests: note how many entries a stack has.
inline void note_stack(int) {}

}  // namespace fastlines

#else

#define FASTLINES_KERNEL extern "C" inline void
#define FASTLINES_UNROLL
#define FASTLINES_NO_UNROLL

namespace fastlines {

/// The number of the thread that the host emulates.
inline thread_local std::uint64_t emulated_thread = 0;

inline std::uint64_t thread_index() { return emulated_thread; }

/// The lowest bit of a mask that has one.
inline int lowest_bit(std::uint32_t mask) { return __builtin_ctz(mask); }

/// The number of bits of a mask.
inline int count_bits(std::uint32_t mask) { return __builtin_popcount(mask); }

/// Add one to a number that all threads share.
inline void add_one(std::uint32_t* number) { ++*number; }

/// The most entries that a stack has had.
inline thread_local int deepest_stack = 0;

/// For tests: note how many entries a stack has.
inline void note_stack(int size) {
  if (size > deepest_stack) deepest_stack = size;
}

/// Runs a kernel as n threads, one after the other.
template <class Kernel, class... Arguments>
void emulate_threads(std::uint64_t n, const Kernel& kernel, const Arguments&... arguments) {
  for (emulated_thread = 0; emulated_thread < n; ++emulated_thread) kernel(arguments...);
}

}  // namespace fastlines

#endif
