// Sixteen lanes of float32, on whatever the compiler may use: FloatX16, and MaskX16 for what comparisons say.
//
// Every operation gives the same bits on every instruction set, but for `fma`, which may round once or twice: it is for
// culling only. min and max are defined as below, also for one float, so that one text serves both.
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
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fastlines {

inline constexpr int kSimdWidth = 16;

/// The bits of the first n lanes, or of all where there are fewer; n > 0.
inline std::uint32_t lane_mask(std::size_t n) { return (2u << std::min<std::size_t>(n - 1, kSimdWidth - 1)) - 1; }

/// Whole numbers whose bits are to be moved in vectors.
inline const float* as_floats(const std::uint32_t* numbers) { return reinterpret_cast<const float*>(numbers); }

/// What a comparison of two N gives.
template <class N>
using MaskOf = decltype(N() <= N());

inline float min(float x, float y) { return x < y ? x : y; }
inline float max(float x, float y) { return x > y ? x : y; }
/// Rounds once or twice, as it does for sixteen.
inline float fma(float x, float y, float z) {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return __builtin_fmaf(x, y, z);
#else
  return x * y + z;
#endif
}
inline float sqrt(float x) { return std::sqrt(x); }
inline float abs(float x) { return std::fabs(x); }
inline float blend(bool mask, float x, float y) { return mask ? x : y; }
inline bool any(bool mask) { return mask; }
inline bool any(MaskX16 mask) { return mask.bits() != 0; }

}  // namespace fastlines
