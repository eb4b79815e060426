// The size of a register of the instruction set compiled for.
#pragma once

namespace fastlines {

#if defined(FASTLINES_PORTABLE)
inline constexpr int kRegisterBytes = 16;
#elif defined(__AVX512F__)
inline constexpr int kRegisterBytes = 64;
#elif defined(__AVX2__)
inline constexpr int kRegisterBytes = 32;
#else
inline constexpr int kRegisterBytes = 16;
#endif

}  // namespace fastlines
