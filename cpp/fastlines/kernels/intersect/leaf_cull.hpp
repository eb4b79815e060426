// The test that culls the pieces of a leaf: which of them may come within reach of a ray's line?
//
// They are seen along the ray, in a plane across it (across.hpp): the ray is the origin, a piece a line from a to c,
// and all is in quanta of the leaf. Rounding an end to a byte moves it by at most √3/2 quanta, and with it every point
// of the piece by no more; the rounding_slack of 0.89 is for the rounding of the arithmetic.
//
// A piece is in reach if an end is, or if its line is and the foot of the perpendicular on it lies between the ends.
// With w = c − a that is
//
//     min(a², c²) ≤ reach²    or    (a × w)² ≤ w²·reach²  and  |a² − c²| ≤ w².
//
// In 16 bits what is seen is exact, but no number is larger than the largest, a good 450 quanta. That loses nothing:
// along an axis two points of a leaf lie no farther apart than that, so where an end, or where the leaf begins, is made
// smaller, all of the piece lies on one side of the origin, and comes nearer. The square of the lowest number along
// both axes is too large for 32 bits and comes out negative: its piece passes.
#pragma once

#include <cstring>
#include <type_traits>

#include "../../layout/wide_bvh.hpp"
#include "projected_ray.hpp"

namespace fastlines {

/// Where a leaf lies offset_from_ray a ray, and how near counts: both in parts of quanta, as long as the axes are.
template <bool has_radius>
[[gnu::always_inline]] inline FloatX4 offset_from_ray(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 org =
      fma(four(leaf.org[2]), two(ray.z),
          fma(four(leaf.org[1]), two(ray.y), fma(four(leaf.org[0]), two(ray.x), four(ray.origin_offset))));
  FloatX4 offset = fma(org, four(leaf.inv_scale), four(ray.rounding_slack));
  if constexpr (has_radius) offset[2] += leaf.radius * offset[3];
  return offset;
}

#if defined(FASTLINES_INT16)

/// What is found of a leaf ahead of the test. For many leaves that lets the processor work on more of them at a time:
/// what waits for it are all instructions of the test.
struct alignas(16) LeafOffset {
  std::int16_t u, v;
  float unused[2], near2;  // the square of how near counts
};

template <bool has_radius = false>
[[gnu::always_inline]] inline LeafOffset leaf_offset(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 at = offset_from_ray<has_radius>(leaf, ray);
  const __m128 near2 = _mm_min_ps(__m128(at * at), _mm_set1_ps(0x1p31f - 128.0f));  // no square is larger
  const __m128i whole = _mm_cvttps_epi32(__m128(at));
  LeafOffset place;
  const __m128 all = _mm_shuffle_ps(_mm_castsi128_ps(_mm_packs_epi32(whole, whole)), near2, _MM_SHUFFLE(2, 2, 0, 0));
  std::memcpy(&place, &all, sizeof place);
  return place;
}

/// The pieces that may come within reach of the ray's line. Most leaves fail at the line already, but too many do not:
/// a branch there costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const ProjectedRay& ray, const WideLeaf& leaf,
                                                      const LeafOffset& place) {
  // Of an axis: x and y in pairs, z and a zero, a zero and z; and where the leaf begins.
  struct Axis {
    Int16s xy, z, second_z, start;

    Axis(const float& packed, std::int16_t start_) : start(Int16s::all(start_)) {
      std::int16_t words[2];
      std::memcpy(words, &packed, sizeof words);
      xy = Int16s::all(words[0]);
      z = Int16s::all(words[1]);
      second_z = z << 8;
    }
    Int16s of_first(Int16s xys, Int16s zs) const { return add_saturated(dot_bytes(xys, xy) + dot_bytes(zs, z), start); }
    Int16s of_second(Int16s xys, Int16s zs) const {
      return add_saturated(dot_bytes(xys, xy) + dot_bytes(zs, second_z), start);
    }
  };
  const Axis u(ray.packed[0], place.u), v(ray.packed[1], place.v);
  const Int32s near2 = Int32s::of(place.near2);
  Int16s near[kSimdWidth / Int16s::kCount];
  for (int i = 0; i < kSimdWidth / Int16s::kCount; ++i) {
    const std::uint8_t* const ends = leaf.ends + i * int(sizeof(Int16s));
    const Int16s zs = Int16s::load(ends + end_byte(0, 2, 0)), as = Int16s::load(ends),
                 cs = Int16s::load(ends + end_byte(1, 0, 0));
    const Int16s au = u.of_first(as, zs), av = v.of_first(as, zs);
    const Int16s cu = u.of_second(cs, zs), cv = v.of_second(cs, zs);
    const Int16s back_u = au - cu, wv = cv - av;  // c − a, but u the other way: cross is a sum
    const auto half = [&]<bool low>() __attribute__((always_inline)) {
      const Int16Pairs a = Int16Pairs::of<low>(au, av), c = Int16Pairs::of<low>(cu, cv),
                       w = Int16Pairs::of<low>(wv, back_u);
      const Int32s aa = dot(a, a), cc = dot(c, c), ww = dot(w, w), cross = dot(a, w);
      // Where a piece is a point the foot does not count: there the ends decide. Less than the whole part of a square
      // is at most 2 less than the square; what 0.89 has to spare is more than 200.
      return (min(aa, cc) < near2) | ((abs(aa - cc) < ww) & is_square_within(cross, ww, place.near2));
    };
    near[i] = join(half.template operator()<true>(), half.template operator()<false>());
  }
  return bits_of(near) & ((1u << leaf.n_refs) - 1);
}

#else

/// What is found of a leaf ahead of the test. For many leaves that lets the processor work on more of them at a time:
/// what waits for it are all instructions of the test.
struct alignas(16) LeafOffset {
  using Start = std::conditional_t<kIntegerAxes, std::int32_t, float>;
  Start u, v;
  float unused, near2;  // the square of how near counts
};

template <bool has_radius = false>
[[gnu::always_inline]] inline LeafOffset leaf_offset(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 at = offset_from_ray<has_radius>(leaf, ray);
  // Where reach is twice as large as the leaf, all pass that can be in reach.
  constexpr float kAll = 512.0f * kAxisLength, kMuch = 1e30f;
  const FloatX4 near2 = max(at * at, fma(at, four(kMuch), four(-kMuch * kAll)));
  LeafOffset place;
  static_assert(sizeof place == sizeof at);
  FloatX4 all;
  // What lies so far beyond the leaf is too large for a whole number, or to be squared; if it is in reach all the same,
  // all pass.
  if constexpr (kIntegerAxes)
    all = FloatX4(__builtin_convertvector(at, IntX4));
  else
    all = min(max(at, four(-1e15f)), four(1e15f));
  all = __builtin_shufflevector(all, near2, 0, 1, 6, 6);
  std::memcpy(&place, &all, sizeof place);
  return place;
}

/// The pieces that may come within reach of the ray's line. Most leaves fail at the line already, but too many do not:
/// a branch there costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const ProjectedRay& ray, const WideLeaf& leaf,
                                                      const LeafOffset& place) {
  using F = FloatX16;
  // Where not all pass, squares are rounded by less than `grain`.
  constexpr float kGrain = 0.5f * kAxisLength * kAxisLength, kTiny = 1e-30f;
  const F near2 = place.near2;
  const Points16 a = Points16::of<0>(leaf.ends), c = Points16::of<1>(leaf.ends);
  const Axis u(ray.x[0], ray.y[0], ray.z[0], ray.packed[0]), v(ray.x[1], ray.y[1], ray.z[1], ray.packed[1]);
  const F au = a.along(u, place.u), av = a.along(v, place.v);
  const F cu = c.along(u, place.u), cv = c.along(v, place.v);
  const F back_u = au - cu, wv = cv - av;  // c − a, but u the other way: cross is a sum
  const F cross = fma(au, wv, av * back_u);
  const F ww = fma(back_u, back_u, wv * wv);
  // Each is what a bound exceeds it by, so that signs decide: comparisons are few, and none waits for another.
  const F a_near = fnma(au, au, fnma(av, av, near2)), c_near = fnma(cu, cu, fnma(cv, cv, near2));
  const F line = fnma(cross, cross, fma(ww, near2, F(-kTiny)));  // not where a piece is a point: there the ends decide
  const F inside = (ww + F(kGrain)) - abs(a_near - c_near);      // the foot of the perpendicular from the origin
  return nonnegative_mask(line, inside, a_near, c_near) & ((1u << leaf.n_refs) - 1);
}

#endif

}  // namespace fastlines
