// Eight lanes of float64, in as few registers as hold them.
//
// Every operation gives the same bits on every instruction set, and those of NumPy.
#pragma once

#include <cstdint>
#include <cstring>

#include "double_x1.hpp"
#include "float_x4.hpp"
#include "register_bytes.hpp"

namespace fastlines {

struct DoubleX8 {
  static constexpr int kBytes = kRegisterBytes, kLanes = 8, kRegisters = 64 / kBytes;
  typedef double Register __attribute__((vector_size(kBytes)));
  typedef std::int64_t MaskRegister __attribute__((vector_size(kBytes)));

  /// All bits of a lane are set, or none.
  struct Mask {
    MaskRegister part[kRegisters];

    friend Mask operator&(const Mask& a, const Mask& b) {
      return of([&](int k) { return a.part[k] & b.part[k]; });
    }
    friend Mask operator|(const Mask& a, const Mask& b) {
      return of([&](int k) { return a.part[k] | b.part[k]; });
    }
    template <class Function>
    [[gnu::always_inline]] static Mask of(Function&& function) {
      Mask made;
      for (int k = 0; k < kRegisters; ++k) made.part[k] = MaskRegister(function(k));
      return made;
    }
  };

  Register part[kRegisters];

  DoubleX8() = default;
  DoubleX8(const DoubleX4& low, const DoubleX4& high) {
#if defined(__AVX512F__) && !defined(FASTLINES_PORTABLE)
    part[0] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
    std::memcpy(part, &low, sizeof low);
    std::memcpy(part + kRegisters / 2, &high, sizeof high);
#endif
  }
  DoubleX8(double x) {
    for (Register& each : part) each = Register{} + x;
  }

  static DoubleX8 load(const double* from) {
    DoubleX8 x;
    std::memcpy(x.part, from, sizeof x.part);
    return x;
  }
  void store(double* to) const { std::memcpy(to, part, sizeof part); }

  friend DoubleX8 operator+(const DoubleX8& a, const DoubleX8& b) {
    return of([&](int k) { return a.part[k] + b.part[k]; });
  }
  friend DoubleX8 operator-(const DoubleX8& a, const DoubleX8& b) {
    return of([&](int k) { return a.part[k] - b.part[k]; });
  }
  friend DoubleX8 operator*(const DoubleX8& a, const DoubleX8& b) {
    return of([&](int k) { return a.part[k] * b.part[k]; });
  }
  friend DoubleX8 operator/(const DoubleX8& a, const DoubleX8& b) {
    return of([&](int k) { return a.part[k] / b.part[k]; });
  }
  friend DoubleX8 operator-(const DoubleX8& a) {
    return of([&](int k) { return -a.part[k]; });
  }
  friend Mask operator<(const DoubleX8& a, const DoubleX8& b) {
    return Mask::of([&](int k) { return a.part[k] < b.part[k]; });
  }
  friend Mask operator<=(const DoubleX8& a, const DoubleX8& b) {
    return Mask::of([&](int k) { return a.part[k] <= b.part[k]; });
  }
  friend Mask operator==(const DoubleX8& a, const DoubleX8& b) {
    return Mask::of([&](int k) { return a.part[k] == b.part[k]; });
  }
  friend Mask operator!=(const DoubleX8& a, const DoubleX8& b) {
    return Mask::of([&](int k) { return a.part[k] != b.part[k]; });
  }

  /// Lanes whose registers are function(0), function(1), …
  template <class Function>
  [[gnu::always_inline]] static DoubleX8 of(Function&& function) {
    DoubleX8 made;
    for (int k = 0; k < kRegisters; ++k) made.part[k] = function(k);
    return made;
  }
};

/// `mask ? x : y` in each lane.
inline DoubleX8 blend(const DoubleX8::Mask& mask, const DoubleX8& x, const DoubleX8& y) {
  return DoubleX8::of([&](int k) { return mask.part[k] ? x.part[k] : y.part[k]; });
}
inline bool any(const DoubleX8::Mask& mask) {
  std::int64_t each[DoubleX8::kLanes], found = 0;
  std::memcpy(each, mask.part, sizeof each);
  for (const std::int64_t lane : each) found |= lane;
  return found != 0;
}
inline DoubleX8 sqrt(const DoubleX8& x) {
  double root[DoubleX8::kLanes];
  x.store(root);
  for (double& each : root) each = std::sqrt(each);
  return DoubleX8::load(root);
}

/// The lanes in which integers are negative.
inline DoubleX8::Mask is_negative(const std::int64_t* eight) {
  DoubleX8::Mask numbers;
  std::memcpy(numbers.part, eight, sizeof numbers.part);
  return DoubleX8::Mask::of([&](int k) { return numbers.part[k] < 0; });
}

/// The columns of eight rows of four floats.
inline void load_columns(const float* const (&rows)[8], DoubleX8 (&columns)[4]) {
  DoubleX4 halves[2][4];
  for (int half = 0; half < 2; ++half) {
    FloatX4 from[4], to[4];
    for (int i = 0; i < 4; ++i) from[i] = load_x4(rows[4 * half + i]);
    transpose(from, to);
    for (int i = 0; i < 4; ++i) to_double(to[i], halves[half][i]);
  }
  for (int i = 0; i < 4; ++i) columns[i] = DoubleX8(halves[0][i], halves[1][i]);
}

}  // namespace fastlines
