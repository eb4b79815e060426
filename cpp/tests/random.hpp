// Random numbers that are the same on every machine: splitmix64, and floats from its high bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fastlines/math/vec.hpp"

namespace fastlines::test {

struct Random {
  std::uint64_t state;

  std::uint64_t operator()() {
    std::uint64_t z = state += 0x9e37'79b9'7f4a'7c15;
    z = (z ^ z >> 30) * 0xbf58'476d'1ce4'e5b9;
    z = (z ^ z >> 27) * 0x94d0'49bb'1331'11eb;
    return z ^ z >> 31;
  }
  std::size_t below(std::size_t n) { return std::size_t((*this)() % n); }
  float uniform() { return float((*this)() >> 40) * 0x1p-24f; }
  float uniform(float from, float to) { return from + uniform() * (to - from); }
  Vec3 in_cube() { return {uniform(), uniform(), uniform()}; }
  Vec3 direction() { return in_cube() - Vec3{0.5f, 0.5f, 0.5f}; }
};

}  // namespace fastlines::test
