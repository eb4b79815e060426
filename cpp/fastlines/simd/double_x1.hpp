// One double with the operations of DoubleX8, so that one template serves both widths, and vectors of three of either.
#pragma once

#include "float_x1.hpp"

namespace fastlines {

inline double sqrt(double x) { return std::sqrt(x); }
inline double blend(bool mask, double x, double y) { return mask ? x : y; }

/// x, but not below the bound; NaN stays.
template <class N>
N at_least(double low, const N& x) {
  return blend(MaskOf<N>(x < N(low)), N(low), x);
}
/// x between 0 and 1; NaN stays.
template <class N>
N clamp_to_1(const N& x) {
  return blend(MaskOf<N>(N(1.0) < x), N(1.0), at_least(0.0, x));
}

/// A vector of three numbers, or eight of them.
template <class N>
struct Vector3 {
  N x, y, z;

  friend Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
  friend Vector3 operator*(const N& s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Vector3 operator/(const Vector3& a, const N& s) { return {a.x / s, a.y / s, a.z / s}; }
};

template <class N>
N dot(const Vector3<N>& a, const Vector3<N>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class N>
Vector3<N> cross(const Vector3<N>& a, const Vector3<N>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class N>
Vector3<N> blend(const MaskOf<N>& mask, const Vector3<N>& a, const Vector3<N>& b) {
  return {blend(mask, a.x, b.x), blend(mask, a.y, b.y), blend(mask, a.z, b.z)};
}
template <class N>
MaskOf<N> is_zero(const Vector3<N>& a) {
  const N zero = 0.0;
  return MaskOf<N>((a.x == zero) & (a.y == zero) & (a.z == zero));
}
/// Unit vectors without negative zeros; NaN for those of length zero.
template <class N>
Vector3<N> unit(const Vector3<N>& a) {
  const N zero = 0.0;
  return a / sqrt(dot(a, a)) + Vector3<N>{zero, zero, zero};
}

}  // namespace fastlines
