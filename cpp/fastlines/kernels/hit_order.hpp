// Puts the hits of sixteen rays in order: by ray, and by t but for those that lie closest together. Two hits are never
// compared by themselves, for what is guessed wrong then costs more than all else that is done for a hit. Few are
// compared with one at a time, and each comes after as many as are less; many are dealt out by the digits of a number.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "lanes.hpp"

namespace fastlines {

class HitOrder {
 public:
  /// Sort hits 0 … n − 1, each of the ray in its lane, at t, of the segment prim.
  void sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    if (const std::size_t room = n + kAtOnce; order_.size() < room)
      for (auto* numbers : {&order_, &last_, &key_}) numbers->resize(2 * room);
    if (n <= 128) {
      make_keys<16, 4, 7>(lane, t, prim, n);
      rank(n);
    } else if (n <= 512) {
      make_keys<12, 0, 0>(lane, t, prim, n);
      deal<2, 8>(n);
    } else if (n <= 2048) {
      make_keys<16, 4, 0>(lane, t, prim, n);
      deal<3, 8>(n);
    } else {
      make_keys<24, 4, 0>(lane, t, prim, n);
      deal<3, 11>(n);
    }
    begin_[kWidth] = n;
  }

  /// The number of the hit that comes k-th.
  std::uint32_t operator[](std::size_t k) const { return order_[k]; }

  /// Where the hits of the ray in this lane begin; those of lane 16 would begin at n.
  std::uint32_t begin(int lane) const { return begin_[lane]; }

 private:
  static constexpr int kLaneBits = 4;

  // A register of numbers, and as many as are compared with a key at once.
  static constexpr int kPerRegister = kWidth / Float16::kRegisters, kRegisters = Float16::kRegisters == 1 ? 2 : 4;
  static constexpr std::uint32_t kAtOnce = kRegisters * kPerRegister;
  using Numbers = std::int32_t __attribute__((vector_size(kPerRegister * sizeof(std::int32_t))));

  /// Keys, of so many bits each: the lane; a step of t; the end of the segment's number, for the pieces of a polyline
  /// are often met where they join, at the same t; and room for a number that tells the rest apart.
  template <int step_bits, int prim_bits, int room_bits>
  void make_keys(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    static_assert(kLaneBits + step_bits + prim_bits + room_bits <= 32);
    Float16 least16 = t[0], most16 = t[0];
    std::uint32_t j = 0;
    for (; j + kWidth <= n; j += kWidth) {
      least16 = min(least16, Float16::load(t + j));
      most16 = max(most16, Float16::load(t + j));
    }
    float from = least(least16), to = -least(Float16(0.0f) - most16);
    for (; j < n; ++j) {
      from = min(from, t[j]);
      to = max(to, t[j]);
    }
    constexpr float last = float((1 << step_bits) - 2);  // so that no key has all bits set
    const float per_t = last / max(to - from, 0x1p-100f);
    std::uint32_t* const key = key_.data();
    for (j = 0; j < n; ++j) {
      const auto step = std::uint32_t(std::int32_t(min((t[j] - from) * per_t, last)));
      key[j] = ((((lane[j] << step_bits) + step) << prim_bits) + prim[j] % (1 << prim_bits)) << room_bits;
    }
  }

  void rank(std::uint32_t n) {
    std::uint32_t below[kAtOnce];
    std::int32_t first_of_lane[kAtOnce] = {};
    for (int lane = 0; lane < kWidth; ++lane) first_of_lane[lane] = lane << (31 - kLaneBits);
    for (std::uint32_t j = 0; j < n; ++j) key_[j] += j;
    std::fill_n(key_.data() + n, kAtOnce, std::numeric_limits<std::int32_t>::max());
    count_below(first_of_lane, n, below);
    std::copy_n(below, kWidth, begin_);
    for (std::uint32_t j = 0; j < n; j += kAtOnce) {
      count_below(key_.data() + j, n, below);
      for (std::uint32_t i = 0; i < kAtOnce; ++i) order_[below[i]] = j + i;
    }
  }

  /// How many of the first n keys are below each of some numbers.
  [[gnu::always_inline]] void count_below(const void* numbers, std::uint32_t n, std::uint32_t (&below)[kAtOnce]) const {
    Numbers some[kRegisters], n_below[kRegisters] = {};
    std::memcpy(some, numbers, sizeof some);
    for (std::uint32_t j = 0; j < n; ++j) {
      const auto key = std::int32_t(key_[j]);
      for (int i = 0; i < kRegisters; ++i) n_below[i] -= key < some[i];
    }
    std::memcpy(below, n_below, sizeof below);
  }

  /// By each digit in turn, the last one first.
  template <int n_digits, int digit_bits>
  void deal(std::uint32_t n) {
    constexpr int key_bits = std::min(n_digits * digit_bits, 32);
    constexpr std::uint32_t n_values = 1 << digit_bits;
    constexpr std::uint32_t per_lane = 1 << (key_bits - (n_digits - 1) * digit_bits - kLaneBits);  // of the first digit
    const auto digit = [key = key_.data()](std::uint32_t j, int i) {
      return key[j] >> digit_bits * i & (n_values - 1);
    };
    std::uint32_t places[n_digits][n_values] = {}, before[n_digits] = {};
    for (std::uint32_t j = 0; j < n; ++j)
      for (int i = 0; i < n_digits; ++i) ++places[i][digit(j, i)];
    for (std::uint32_t value = 0; value < n_values; ++value) {
      if (value % per_lane == 0 && value < kWidth * per_lane) begin_[value / per_lane] = before[n_digits - 1];
      for (int i = 0; i < n_digits; ++i) before[i] += std::exchange(places[i][value], before[i]);
    }
    for (std::uint32_t j = 0; j < n; ++j) order_[places[0][digit(j, 0)]++] = j;
    for (int i = 1; i < n_digits; ++i) {
      std::swap(order_, last_);
      for (std::uint32_t k = 0; k < n; ++k) order_[places[i][digit(last_[k], i)]++] = last_[k];
    }
  }

  std::vector<std::uint32_t> order_, last_, key_;
  std::uint32_t begin_[kWidth + 1];
};

}  // namespace fastlines
