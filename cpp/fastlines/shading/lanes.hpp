// 16 numbers that shading computes with at a time: vectors of the compiler, which knows them for each instruction set.
//
// Shading is defined by float32 arithmetic in a fixed order, without fused multiply-adds. So all instruction sets and
// all numbers of threads give the same picture, bit for bit.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace fastlines {

inline constexpr int kLanes = 16;

/// The bytes of a register of the instruction set.
#if defined(__AVX512F__)
inline constexpr int kRegisterBytes = 64;
#elif defined(__AVX2__)
inline constexpr int kRegisterBytes = 32;
#else
inline constexpr int kRegisterBytes = 16;
#endif

/// 16 numbers of four bytes, in as few registers as hold them.
template <class T>
struct Lanes {
  typedef T Register __attribute__((vector_size(kRegisterBytes)));
  using Mask = Lanes<std::int32_t>;
  static constexpr int kRegisters = kLanes * int(sizeof(T)) / kRegisterBytes, kPerRegister = kLanes / kRegisters;
  Register part[kRegisters];

  Lanes() = default;
  Lanes(T x) {
    for (Register& each : part) each = Register{} + x;
  }

  T operator[](int i) const { return part[i / kPerRegister][i % kPerRegister]; }
  void set(int i, T x) { part[i / kPerRegister][i % kPerRegister] = x; }

  friend Lanes operator+(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] + b.part[k]; }); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] - b.part[k]; }); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] * b.part[k]; }); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] / b.part[k]; }); }
  friend Lanes operator-(const Lanes& a) { return of([&](int k) { return -a.part[k]; }); }
  friend Lanes operator&(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] & b.part[k]; }); }
  friend Lanes operator|(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] | b.part[k]; }); }
  friend Lanes operator^(const Lanes& a, const Lanes& b) { return of([&](int k) { return a.part[k] ^ b.part[k]; }); }
  friend Lanes operator<<(const Lanes& a, int n) { return of([&](int k) { return a.part[k] << n; }); }
  friend Lanes operator>>(const Lanes& a, int n) { return of([&](int k) { return a.part[k] >> n; }); }
  friend Mask operator<(const Lanes& a, const Lanes& b) { return Mask::of([&](int k) { return a.part[k] < b.part[k]; }); }
  friend Mask operator<=(const Lanes& a, const Lanes& b) {
    return Mask::of([&](int k) { return a.part[k] <= b.part[k]; });
  }
  friend Mask operator>(const Lanes& a, const Lanes& b) { return b < a; }
  friend Mask operator>=(const Lanes& a, const Lanes& b) { return b <= a; }
  friend Mask operator==(const Lanes& a, const Lanes& b) {
    return Mask::of([&](int k) { return a.part[k] == b.part[k]; });
  }
  friend Mask operator!=(const Lanes& a, const Lanes& b) {
    return Mask::of([&](int k) { return a.part[k] != b.part[k]; });
  }
  Lanes& operator+=(const Lanes& b) { return *this = *this + b; }
  Lanes& operator*=(const Lanes& b) { return *this = *this * b; }

  /// Lanes whose registers are function(0), function(1), …
  template <class Function>
  [[gnu::always_inline]] static Lanes of(Function&& function) {
    Lanes made;
    for (int k = 0; k < kRegisters; ++k) made.part[k] = function(k);
    return made;
  }
};

using FloatLanes = Lanes<float>;
using IntLanes = Lanes<std::int32_t>;
using WordLanes = Lanes<std::uint32_t>;

/// `mask ? x : y` in each lane. Lanes of a mask, which comparisons return, are −1 or 0.
template <class T>
Lanes<T> select(const IntLanes& mask, const Lanes<T>& x, const Lanes<T>& y) {
  return Lanes<T>::of([&](int k) { return mask.part[k] ? x.part[k] : y.part[k]; });
}
inline FloatLanes min(const FloatLanes& x, const FloatLanes& y) { return select(y < x, y, x); }
inline FloatLanes max(const FloatLanes& x, const FloatLanes& y) { return select(x < y, y, x); }
inline FloatLanes clamp(const FloatLanes& x, float low, float high) { return min(max(x, low), high); }

/// The same bits as lanes of another type.
template <class To, class From>
Lanes<To> bit_cast(const Lanes<From>& x) {
  return Lanes<To>::of([&](int k) { return typename Lanes<To>::Register(x.part[k]); });
}
inline FloatLanes to_float(const IntLanes& x) {
  return FloatLanes::of([&](int k) { return __builtin_convertvector(x.part[k], FloatLanes::Register); });
}
/// Truncated.
inline IntLanes to_int(const FloatLanes& x) {
  return IntLanes::of([&](int k) { return __builtin_convertvector(x.part[k], IntLanes::Register); });
}

inline FloatLanes abs(const FloatLanes& x) { return bit_cast<float>(bit_cast<std::int32_t>(x) & 0x7fff'ffff); }
/// x where y is positive, −x where it is negative.
inline FloatLanes times_sign(const FloatLanes& x, const FloatLanes& y) {
  return bit_cast<float>(bit_cast<std::uint32_t>(x) ^ (bit_cast<std::uint32_t>(y) & 0x8000'0000u));
}
/// The nearest whole number of |x| < 2²²; of two the even one.
inline FloatLanes round(const FloatLanes& x) {
  const float magic = 12582912.0f;  // 1.5·2²³
  return (x + magic) - magic;
}
inline FloatLanes sqrt(const FloatLanes& x) {
  float root[kLanes];
  std::memcpy(root, &x, sizeof root);
  for (float& each : root) each = std::sqrt(each);
  FloatLanes roots;
  std::memcpy(&roots, root, sizeof root);
  return roots;
}

/// Whether the mask is set in any lane.
inline bool any(const IntLanes& mask) {
  std::int32_t each[kLanes], found = 0;
  std::memcpy(each, &mask, sizeof each);
  for (const std::int32_t lane : each) found |= lane;
  return found != 0;
}

/// The first n of 16 numbers; the other lanes repeat the last of them. n is at least 1.
template <class T>
Lanes<T> load_lanes(const T* from, int n) {
  T each[kLanes];
  for (int i = 0; i < kLanes; ++i) each[i] = from[i < n ? i : n - 1];
  Lanes<T> x;
  std::memcpy(&x, n < kLanes ? each : from, sizeof x);
  return x;
}
/// Store the first n of 16 numbers.
template <class T>
void store_lanes(const Lanes<T>& x, T* to, int n) {
  if (n >= kLanes)
    std::memcpy(to, &x, sizeof x);
  else
    std::memcpy(to, &x, std::size_t(n) * sizeof(T));
}

/// 16 vectors of three numbers: of points, of directions, or of red, green and blue.
struct Vec3Lanes {
  FloatLanes x, y, z;

  /// Rows of three numbers, as NumPy has them: the first n of 16, of which the others repeat the last.
  static Vec3Lanes load(const float* from, int n) {
    float x[kLanes], y[kLanes], z[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const float* const row = from + 3 * (i < n ? i : n - 1);
      x[i] = row[0];
      y[i] = row[1];
      z[i] = row[2];
    }
    return {load_lanes(x, kLanes), load_lanes(y, kLanes), load_lanes(z, kLanes)};
  }
  void store(float* to, int n) const {
    float all[3][kLanes];
    std::memcpy(all, this, sizeof all);
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) to[3 * i + k] = all[k][i];
  }
  static Vec3Lanes of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

  friend Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3Lanes operator*(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend Vec3Lanes operator*(const FloatLanes& s, const Vec3Lanes& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a) { return {-a.x, -a.y, -a.z}; }
};

inline FloatLanes dot(const Vec3Lanes& a, const Vec3Lanes& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3Lanes cross(const Vec3Lanes& a, const Vec3Lanes& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3Lanes select(const IntLanes& mask, const Vec3Lanes& a, const Vec3Lanes& b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
/// Unit vectors; zero for those of length zero.
inline Vec3Lanes unit(const Vec3Lanes& a) {
  const FloatLanes length = sqrt(dot(a, a)), zero = 0.0f;
  return select(length > zero, 1.0f / length, zero) * a;
}

}  // namespace fastlines
