// FloatX16, 16 lanes of float32, and MaskX16, the result of its comparisons, for the instruction set compiled for.
//
// Every operation gives the same bits on every instruction set, except `fma` and `fnma`. These may round once or twice
// and are for culling only. With the overloads for one float in float_x1.hpp, one template serves both widths. In both,
// min(x, y) is x < y ? x : y and max(x, y) is x > y ? x : y, also for NaN and zeros.
#pragma once

#if defined(FASTLINES_PORTABLE)
#include "x4.hpp"
#elif defined(__AVX512F__)
#include "avx512.hpp"
#elif defined(__AVX2__) && defined(__FMA__)
#include "avx2.hpp"
#else
#include "x4.hpp"
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "float_x1.hpp"

namespace fastlines {

/// A mask of the first min(n, 16) lanes, n > 0.
inline std::uint32_t lane_mask(std::size_t n) { return (2u << std::min<std::size_t>(n - 1, kSimdWidth - 1)) - 1; }

/// Integers as floats of the same bits, for operations that only move lanes.
inline const float* as_floats(const std::uint32_t* numbers) { return reinterpret_cast<const float*>(numbers); }

inline bool any(MaskX16 mask) { return mask.bits() != 0; }

/// The maximum over all lanes.
inline float reduce_max(FloatX16 x) { return -reduce_min(FloatX16(0.0f) - x); }

}  // namespace fastlines
