// One float with the operations of FloatX16, so that one template serves both widths.
//
// GPUs compile this file too (device/kernels.hpp).
#pragma once

#include <cmath>

namespace fastlines {

/// The lanes of a FloatX16, and the most children of a wide node.
inline constexpr int kSimdWidth = 16;

/// The type of a comparison of two N: bool or MaskX16.
template <class N>
using MaskOf = decltype(N() <= N());

inline float min(float x, float y) { return x < y ? x : y; }
inline float max(float x, float y) { return x > y ? x : y; }
/// May round once or twice, as the overload for 16 lanes may: for culling only.
inline float fma(float x, float y, float z) {
#if defined(__CUDACC__)
  return ::fmaf(x, y, z);
#elif defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return __builtin_fmaf(x, y, z);
#else
  return x * y + z;
#endif
}
inline float sqrt(float x) { return std::sqrt(x); }
inline float abs(float x) { return std::fabs(x); }
inline float blend(bool mask, float x, float y) { return mask ? x : y; }
inline bool any(bool mask) { return mask; }

}  // namespace fastlines
