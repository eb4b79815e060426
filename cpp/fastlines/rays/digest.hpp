// A checksum of float arrays that notices changes: of one number or many, of signs, and of the order of numbers.
//
// Blocks are hashed by NH, of Black, Halevi, Krawczyk, Krovetz and Rogaway, "UMAC: Fast and Secure Message
// Authentication", 1999, §4: h = Σ (aᵢ + kᵢ)·(bᵢ + k'ᵢ) in 64 bits, where a and b are the two halves of the block. Two
// different blocks of the same length collide for one choice of the keys k in 2³². The keys are constant, so the digest
// is no defence against someone who computes a collision.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace fastlines {

/// The numbers in a block.
inline constexpr std::size_t kDigestBlock = 1024;

/// Mixes the bits of an integer: splitmix64, by Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
/// Generators", 2014.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e37'79b9'7f4a'7c15;
  x = (x ^ x >> 30) * 0xbf58'476d'1ce4'e5b9;
  x = (x ^ x >> 27) * 0x94d0'49bb'1331'11eb;
  return x ^ x >> 31;
}

/// The keys of a block.
inline constexpr auto kDigestKeys = [] {
  std::array<std::uint32_t, kDigestBlock> keys{};
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = std::uint32_t(mix_bits(i) >> 32);
  return keys;
}();

/// The hash of a block or of less. The last number of an odd count is paired with zero.
inline std::uint64_t hash_block(std::span<const float> numbers) {
  const std::size_t n_pairs = numbers.size() / 2, half = numbers.size() - n_pairs;
  const auto keyed = [&](std::size_t i) { return std::bit_cast<std::uint32_t>(numbers[i]) + kDigestKeys[i]; };
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < n_pairs; ++i) sum += std::uint64_t(keyed(i)) * keyed(half + i);
  return half > n_pairs ? sum + std::uint64_t(keyed(n_pairs)) * kDigestKeys[kDigestBlock - 1] : sum;
}

/// The digest of some numbers of an array, the first of which begins a block at `first`. The digests of parts add up to
/// that of the array; `seed` tells arrays apart.
inline std::uint64_t digest_of(std::span<const float> numbers, std::size_t first, std::uint64_t seed) {
  std::uint64_t digest = 0;
  for (std::size_t begin = 0; begin < numbers.size(); begin += kDigestBlock) {
    const std::size_t n = std::min(kDigestBlock, numbers.size() - begin);
    const std::uint64_t place = mix_bits(mix_bits(seed) + (first + begin) / kDigestBlock);
    digest += mix_bits(hash_block(numbers.subspan(begin, n)) ^ place);
  }
  return digest;
}

}  // namespace fastlines
