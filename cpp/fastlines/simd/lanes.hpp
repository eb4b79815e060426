// 16 numbers that shading and gathers compute with at a time: vectors of the compiler, which knows them for each
// instruction set.
//
// Both are defined by float32 arithmetic in a fixed order, without fused multiply-adds. So all instruction sets and all
// numbers of threads give the same picture and the same sums, bit for bit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "register_bytes.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace fastlines {

inline constexpr int kLanes = 16;

/// 16 numbers of four bytes, in as few registers as hold them.
template <class T>
struct Lanes {
  typedef T Register __attribute__((vector_size(kRegisterBytes)));
  /// A register in an array. Compilers copy more than a register by narrower moves, which are not
  /// forwarded to wide loads: these then stall.
  typedef T Stored __attribute__((vector_size(kRegisterBytes), aligned(alignof(T)), may_alias));
  using Mask = Lanes<std::int32_t>;
  static constexpr int kRegisters = kLanes * int(sizeof(T)) / kRegisterBytes, kPerRegister = kLanes / kRegisters;
  Register part[kRegisters];

  Lanes() = default;
  Lanes(T x) {
    for (Register& each : part) each = Register{} + x;
  }

  static Lanes load(const T* from) {
    return of([=](int k) { return Register(reinterpret_cast<const Stored*>(from)[k]); });
  }
  void store(T* to) const {
    for (int k = 0; k < kRegisters; ++k) reinterpret_cast<Stored*>(to)[k] = part[k];
  }

  T operator[](int i) const { return part[i / kPerRegister][i % kPerRegister]; }
  void set(int i, T x) { part[i / kPerRegister][i % kPerRegister] = x; }

  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] + b.part[k]; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] - b.part[k]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] * b.part[k]; });
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] / b.part[k]; });
  }
  friend Lanes operator-(const Lanes& a) {
    return of([&](int k) { return -a.part[k]; });
  }
  friend Lanes operator&(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] & b.part[k]; });
  }
  friend Lanes operator|(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] | b.part[k]; });
  }
  friend Lanes operator^(const Lanes& a, const Lanes& b) {
    return of([&](int k) { return a.part[k] ^ b.part[k]; });
  }
  friend Lanes operator<<(const Lanes& a, int n) {
    return of([&](int k) { return a.part[k] << n; });
  }
  friend Lanes operator>>(const Lanes& a, int n) {
    return of([&](int k) { return a.part[k] >> n; });
  }
  friend Mask operator<(const Lanes& a, const Lanes& b) {
    return Mask::of([&](int k) { return a.part[k] < b.part[k]; });
  }
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
/// Truncated. Of NaN, and of what does not fit, any number: the conversion of C++ would make all that follows
/// undefined.
inline IntLanes to_int(const FloatLanes& x) {
  return IntLanes::of([&](int k) {
#if defined(__AVX512F__) && !defined(FASTLINES_PORTABLE)
    return IntLanes::Register(_mm512_cvttps_epi32(x.part[k]));
#elif defined(__AVX2__) && !defined(FASTLINES_PORTABLE)
    return IntLanes::Register(_mm256_cvttps_epi32(x.part[k]));
#elif defined(__SSE2__) && !defined(FASTLINES_PORTABLE)
    return IntLanes::Register(_mm_cvttps_epi32(x.part[k]));
#else
    IntLanes::Register whole = {};
    for (int i = 0; i < IntLanes::kPerRegister; ++i) {
      const float number = x.part[k][i];
      whole[i] = std::fabs(number) < 0x1p31f ? std::int32_t(number) : std::numeric_limits<std::int32_t>::min();
    }
    return whole;
#endif
  });
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
  return FloatLanes::of([&](int k) {
#if defined(__AVX512F__) && !defined(FASTLINES_PORTABLE)
    return FloatLanes::Register(_mm512_sqrt_ps(x.part[k]));
#elif defined(__AVX2__) && !defined(FASTLINES_PORTABLE)
    return FloatLanes::Register(_mm256_sqrt_ps(x.part[k]));
#elif defined(__SSE2__) && !defined(FASTLINES_PORTABLE)
    return FloatLanes::Register(_mm_sqrt_ps(x.part[k]));
#else
    FloatLanes::Register roots;
    for (int i = 0; i < FloatLanes::kPerRegister; ++i) roots[i] = std::sqrt(x.part[k][i]);
    return roots;
#endif
  });
}

/// Whether the mask is set in any lane.
inline bool any(const IntLanes& mask) {
  IntLanes::Register found = mask.part[0];
  for (int k = 1; k < IntLanes::kRegisters; ++k) found |= mask.part[k];
#if defined(__AVX512F__) && !defined(FASTLINES_PORTABLE)
  return _mm512_movepi32_mask((__m512i)found) != 0;
#elif defined(__AVX2__) && !defined(FASTLINES_PORTABLE)
  return _mm256_movemask_ps((__m256)found) != 0;
#elif defined(__SSE2__) && !defined(FASTLINES_PORTABLE)
  return _mm_movemask_ps((__m128)found) != 0;
#else
  std::int32_t lanes = 0;
  for (int i = 0; i < IntLanes::kPerRegister; ++i) lanes |= found[i];
  return lanes != 0;
#endif
}

/// The first n of 16 numbers; the other lanes repeat the last of them. n is at least 1.
template <class T>
Lanes<T> load_lanes(const T* from, int n) {
  T repeated[kLanes];
  if (n < kLanes) {
    for (int i = 0; i < kLanes; ++i) repeated[i] = from[std::min(i, n - 1)];
    from = repeated;
  }
  return Lanes<T>::load(from);
}
/// Store the first n of 16 numbers.
template <class T>
void store_lanes(const Lanes<T>& x, T* to, int n) {
  if (n >= kLanes) return x.store(to);
  T each[kLanes];
  x.store(each);
  std::copy_n(each, n, to);
}

/// 16 vectors of three numbers: of points, of directions, or of red, green and blue.
struct Vec3Lanes {
  FloatLanes x, y, z;

  /// Rows of three numbers, as NumPy has them: the first n of 16, of which the others repeat the last.
  static Vec3Lanes load(const float* from, int n) {
    float repeated[3 * kLanes];
    if (n < kLanes) {
      for (int i = 0; i < kLanes; ++i) std::copy_n(from + 3 * std::min(i, n - 1), 3, repeated + 3 * i);
      from = repeated;
    }
    Vec3Lanes v;
    for (int k = 0; k < FloatLanes::kRegisters; ++k) {
      const auto* const stored = reinterpret_cast<const FloatLanes::Stored*>(from) + 3 * k;
      const Register rows[3] = {stored[0], stored[1], stored[2]};
      v.x.part[k] = column<0>(rows, Each());
      v.y.part[k] = column<1>(rows, Each());
      v.z.part[k] = column<2>(rows, Each());
    }
    return v;
  }
  void store(float* to, int n) const {
    float all[3 * kLanes];
    for (int k = 0; k < FloatLanes::kRegisters; ++k) {
      auto* const stored = reinterpret_cast<FloatLanes::Stored*>(n < kLanes ? all : to) + 3 * k;
      stored[0] = row<0>(k, Each());
      stored[1] = row<1>(k, Each());
      stored[2] = row<2>(k, Each());
    }
    if (n < kLanes) std::copy_n(all, 3 * n, to);
  }
  static Vec3Lanes of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

  friend Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3Lanes operator*(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend Vec3Lanes operator*(const FloatLanes& s, const Vec3Lanes& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend Vec3Lanes operator-(const Vec3Lanes& a) { return {-a.x, -a.y, -a.z}; }

 private:
  using Register = FloatLanes::Register;
  static constexpr int kWidth = FloatLanes::kPerRegister;
  using Each = std::make_integer_sequence<int, kWidth>;

  /// Every third number of three registers, from the k-th.
  template <int k, int... i>
  [[gnu::always_inline]] static Register column(const Register (&rows)[3], std::integer_sequence<int, i...>) {
    constexpr auto in_first = [](int lane) { return 3 * lane + k < 2 * kWidth; };
    const Register first = __builtin_shufflevector(rows[0], rows[1], (in_first(i) ? 3 * i + k : 0)...);
    return __builtin_shufflevector(first, rows[2], (in_first(i) ? i : 3 * i + k - kWidth)...);
  }
  /// The j-th of the three registers that hold register k of x, y and z as rows.
  template <int j, int... i>
  [[gnu::always_inline]] Register row(int k, std::integer_sequence<int, i...>) const {
    constexpr auto point = [](int lane) { return (j * kWidth + lane) / 3; };
    constexpr auto axis = [](int lane) { return (j * kWidth + lane) % 3; };
    const Register xy = __builtin_shufflevector(x.part[k], y.part[k], (point(i) + (axis(i) == 1 ? kWidth : 0))...);
    return __builtin_shufflevector(xy, z.part[k], (axis(i) == 2 ? kWidth + point(i) : i)...);
  }
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
