// Vectors of three floats and their operations, and infinity.
#pragma once

#include <array>
#include <limits>

namespace fastlines {

static_assert(sizeof(void*) == 8, "fastlines needs a 64-bit processor: sizes of trees and answers pass 2^32 bytes");

using Vec3 = std::array<float, 3>;

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec3 operator*(const Vec3& a, float s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline float dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace fastlines
