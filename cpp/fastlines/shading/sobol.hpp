// Owen-scrambled Sobol points of 16 sequences at a time, bit for bit those of fastlines.rendering.sampling.sobol, which
// defines them and names the sources.
//
// Two steps are reversals of bits that cancel here. The second coordinate is the index times Pascal's triangle mod 2.
// By Lucas's theorem, bit i of that is the sum of all bits j of the index whose number j contains the bits of i.
#pragma once

#include "../simd/lanes.hpp"

namespace fastlines {

/// The number of dimensions of a path that are evenly distributed; later ones are independent random numbers.
inline constexpr int kEvenDimensions = 24;

/// Well-mixed words, other ones for another salt.
inline WordLanes hashed(const WordLanes& words, std::uint32_t salt = 0) {
  WordLanes mixed = words + 0x9E3779B9u * (salt + 1);
  mixed = (mixed ^ (mixed >> 16)) * 0x21F0AAADu;
  mixed = (mixed ^ (mixed >> 15)) * 0x735A2D97u;
  return mixed ^ (mixed >> 15);
}

inline WordLanes reversed_bits(WordLanes words) {
  words = ((words >> 1) & 0x55555555u) | ((words & 0x55555555u) << 1);
  words = ((words >> 2) & 0x33333333u) | ((words & 0x33333333u) << 2);
  words = ((words >> 4) & 0x0F0F0F0Fu) | ((words & 0x0F0F0F0Fu) << 4);
  words = ((words >> 8) & 0x00FF00FFu) | ((words & 0x00FF00FFu) << 8);
  return (words >> 16) | (words << 16);
}

/// Flips each bit by a function of its lower bits and the seed: Owen's scrambling of words whose bits are reversed.
inline WordLanes scrambled_upwards(WordLanes words, const WordLanes& seeds) {
  words = words ^ (words * 0x3D20ADEAu);
  words += seeds;
  words *= (seeds >> 16) | 1u;
  words = words ^ (words * 0x05526C56u);
  return words ^ (words * 0x53A22864u);
}

/// The second coordinate of the Sobol sequence, with its bits reversed.
inline WordLanes reversed_sobol(WordLanes index) {
  index = index ^ ((index >> 1) & 0x55555555u);
  index = index ^ ((index >> 2) & 0x33333333u);
  index = index ^ ((index >> 4) & 0x0F0F0F0Fu);
  index = index ^ ((index >> 8) & 0x00FF00FFu);
  return index ^ ((index >> 16) & 0x0000FFFFu);
}

/// Numbers in [0, 1) of the upper 24 bits.
inline FloatLanes fractions(const WordLanes& words) { return to_float(bit_cast<std::int32_t>(words >> 8)) * 0x1p-24f; }

/// One coordinate of sample `index` of the sequence of each seed.
inline FloatLanes uniforms(std::uint32_t index, const WordLanes& seeds, int dimension) {
  const auto pair = std::uint32_t(dimension) / 2, axis = std::uint32_t(dimension) % 2;
  const WordLanes own = hashed(seeds, pair);
  WordLanes words = index;
  if (pair) words = reversed_bits(scrambled_upwards(reversed_bits(words), own));
  if (axis) words = reversed_sobol(words);
  return fractions(reversed_bits(scrambled_upwards(words, hashed(own, 0x5BD1u + axis))));
}

/// The numbers of one sample of 16 paths, one dimension after another.
class PathNumbers {
 public:
  PathNumbers(std::uint32_t index, const WordLanes& seeds, int dimension)
      : index_(index), seeds_(seeds), dimension_(dimension) {}

  /// The next n numbers. A pair of dimensions is never split.
  template <int n>
  void take(FloatLanes (&u)[n]) {
    const int first = dimension_;
    dimension_ += n + n % 2;
    if (dimension_ <= kEvenDimensions) {
      for (int i = 0; i < n; ++i) u[i] = uniforms(index_, seeds_, first + i);
    } else {
      const WordLanes seeds = hashed(seeds_ + hashed(index_));
      for (int i = 0; i < n; ++i) u[i] = fractions(hashed(seeds, std::uint32_t(first + i)));
    }
  }

  int dimension() const { return dimension_; }

 private:
  std::uint32_t index_;
  WordLanes seeds_;
  int dimension_;
};

}  // namespace fastlines
