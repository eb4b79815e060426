// Puts the hits of sixteen rays in order: by ray, and by t but for those that lie closest together. Two hits are never
// compared by themselves, for what is guessed wrong then costs more than all else that is done for a hit. Few are
// compared with one at a time, and each comes after as many as are less; many are dealt out by the digits of a number.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "lanes.hpp"

namespace fastlines {

class HitOrder {
 public:
  /// Sort hits 0 … n − 1, one at least, each of the ray in its lane, at t, of the segment prim.
  void sort(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    if (const std::size_t room = n + kAtOnce + kUnrolled; order_.size() < room)
      for (auto* numbers : {&order_, &last_, &key_}) numbers->resize(2 * room);
    if (find_begins(lane, n) <= kFew)
      rank(lane, t, prim, n);
    else if (n <= 2048)
      deal<8>(lane, t, prim, n);
    else
      deal<11>(lane, t, prim, n);
  }

  /// The number of the hit that comes k-th.
  std::uint32_t operator[](std::size_t k) const { return order_[k]; }

  /// Where the hits of the ray in this lane begin; those of lane 16 would begin at n.
  std::uint32_t begin(int lane) const { return begin_[lane]; }

 private:
  static constexpr int kLaneBits = 4, kPrimBits = 4;
  static constexpr std::uint32_t kFew = 64;  // hits of a ray: for more, comparing takes longer than dealing
  static constexpr std::uint32_t kUnrolled = 8;

  // A register of numbers, and as many as are compared with a key at once.
  static constexpr int kPerRegister = kWidth / Float16::kRegisters, kRegisters = Float16::kRegisters == 1 ? 2 : 4;
  static constexpr std::uint32_t kAtOnce = kRegisters * kPerRegister;
  using Numbers = std::int32_t __attribute__((vector_size(kPerRegister * sizeof(std::int32_t))));

  /// Where the hits of each lane begin; returns how many the lane of most has.
  std::uint32_t find_begins(const std::uint32_t* lane, std::uint32_t n) {
    std::uint32_t n_of[2][kWidth] = {};
    for (std::uint32_t j = 0; j + 1 < n; j += 2) {
      ++n_of[0][lane[j]];
      ++n_of[1][lane[j + 1]];
    }
    if (n % 2) ++n_of[0][lane[n - 1]];
    std::uint32_t most = 0;
    begin_[0] = 0;
    for (int i = 0; i < kWidth; ++i) {
      const std::uint32_t here = n_of[0][i] + n_of[1][i];
      most = std::max(most, here);
      begin_[i + 1] = begin_[i] + here;
    }
    return most;
  }

  /// Keys: the lane; a step of t; the end of the segment's number, for the pieces of a polyline are often met where
  /// they join, at the same t; and room for a number that tells the rest apart. All in so many bits.
  void make_keys(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n, int bits,
                 int room_bits) {
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
    const int step_bits = std::min(bits - room_bits - kPrimBits - kLaneBits, 24);  // as exact as floats are
    const float last = float((1 << step_bits) - 2);                                // so that no key has all bits set
    const float per_t = last / max(to - from, 0x1p-100f);
    std::uint32_t* const key = key_.data();
    for (j = 0; j < n; ++j) {
      const auto step = std::uint32_t(std::int32_t(min((t[j] - from) * per_t, last)));
      key[j] = ((((lane[j] << step_bits) + step) << kPrimBits) + prim[j] % (1 << kPrimBits)) << room_bits;
    }
  }

  /// Few hits of each ray: all that are of one ray are brought together, and each is compared with those around it.
  void rank(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    const int room_bits = std::bit_width(n);
    make_keys(lane, t, prim, n, 32, room_bits);
    constexpr std::uint32_t sign = 1u << 31;  // with it the other way, keys are in order as signed numbers
    const std::uint32_t* const key = key_.data();
    std::uint32_t* const sorted = last_.data();
    std::uint32_t at[kWidth];
    std::copy_n(begin_, kWidth, at);
    for (std::uint32_t j = 0; j < n; ++j) sorted[at[lane[j]]++] = (key[j] + j) ^ sign;
    std::fill_n(sorted + n, kAtOnce + kUnrolled, sign - 1);
    const auto lane_of = [=](std::uint32_t k) { return (sorted[k] ^ sign) >> (32 - kLaneBits); };
    std::uint32_t below[kAtOnce];
    for (std::uint32_t k = 0; k < n; k += kAtOnce) {
      const std::uint32_t first = lane_of(k), last = lane_of(std::min(k + kAtOnce, n) - 1);
      count_below(sorted + k, sorted, begin_[first], begin_[last + 1], below);
      for (std::uint32_t i = 0; i < kAtOnce; ++i) order_[below[i]] = sorted[k + i] & ((1u << room_bits) - 1);
    }
  }

  /// For each of some keys, how many are less: all before `begin`, and those that are found from there to `end`. What
  /// is not less may be read past the end.
  [[gnu::always_inline]] static void count_below(const std::uint32_t* some_keys, const std::uint32_t* keys,
                                                 std::uint32_t begin, std::uint32_t end,
                                                 std::uint32_t (&below)[kAtOnce]) {
    Numbers some[kRegisters], n_below[kRegisters];
    std::memcpy(some, some_keys, sizeof some);
    for (Numbers& numbers : n_below) numbers = Numbers{} + std::int32_t(begin);
    for (std::uint32_t j = begin; j < end; j += kUnrolled)
      for (std::uint32_t k = 0; k < kUnrolled; ++k) {
        const auto key = std::int32_t(keys[j + k]);
        for (int i = 0; i < kRegisters; ++i) n_below[i] -= key < some[i];
      }
    std::memcpy(below, n_below, sizeof below);
  }

  /// Many hits: by each of three digits of their keys in turn, the last one first.
  template <int digit_bits>
  void deal(const std::uint32_t* lane, const float* t, const std::uint32_t* prim, std::uint32_t n) {
    constexpr int n_digits = 3;
    constexpr std::uint32_t n_values = 1 << digit_bits;
    make_keys(lane, t, prim, n, std::min(n_digits * digit_bits, 32), 0);
    const auto digit = [key = key_.data()](std::uint32_t j, int i) {
      return key[j] >> digit_bits * i & (n_values - 1);
    };
    std::uint32_t places[n_digits][n_values] = {}, before[n_digits] = {};
    for (std::uint32_t j = 0; j < n; ++j)
      for (int i = 0; i < n_digits; ++i) ++places[i][digit(j, i)];
    for (std::uint32_t value = 0; value < n_values; ++value)
      for (int i = 0; i < n_digits; ++i) before[i] += std::exchange(places[i][value], before[i]);
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
