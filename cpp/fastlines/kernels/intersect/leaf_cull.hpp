// Culls the pieces of a leaf that do not come within the culling radius of a ray's line.
//
// Pieces are projected along the ray onto the plane perpendicular to it (projected_ray.hpp). The ray becomes the
// origin, a piece a 2D segment from a to c. Lengths are in quanta of the leaf. Rounding an end to a byte moves it by at
// most √3/2 = 0.866 quanta, and no point of the piece moves farther. So the radius d of the test has a slack of 0.89
// quanta, which also covers the rounding of the arithmetic.
//
// A piece passes if an end is within d of the ray, or if its line is and the foot of the perpendicular lies between the
// ends. With w = c − a that is
//
//     min(a², c²) ≤ d²    or    (a × w)² ≤ w²·d²  and  |a² − c²| ≤ w².
//
// In 16 bits, projections are exact but saturate, at some 450 quanta. Saturation loses nothing: along an axis, two
// points of a leaf are no farther apart than that. So if an end or the leaf's origin saturates, the whole piece lies on
// one side of the ray, and saturation only moves it nearer. If both coordinates of an end are −2¹⁵, its square
// overflows 32 bits and is negative: its piece passes.
#pragma once

#include <cstring>
#include <type_traits>

#include "../../layout/wide_bvh.hpp"
#include "projected_ray.hpp"

namespace fastlines {

/// The leaf's origin projected onto U and V, and the culling radius in lane 2: in quanta, times the length of the axes.
template <bool has_radius>
[[gnu::always_inline]] inline FloatX4 offset_from_ray(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 org = fma(broadcast_x4(leaf.org[2]), load_x2(ray.z),
                          fma(broadcast_x4(leaf.org[1]), load_x2(ray.y),
                              fma(broadcast_x4(leaf.org[0]), load_x2(ray.x), load_x4(ray.origin_offset))));
  FloatX4 offset = fma(org, broadcast_x4(leaf.inv_scale), load_x4(ray.rounding_slack));
  if constexpr (has_radius) offset[2] += leaf.radius * offset[3];
  return offset;
}

#if defined(FASTLINES_INT16)

/// The offset of a leaf from a ray. All instructions of the test depend on it, so kernels compute offsets ahead: then
/// the processor overlaps the tests.
struct alignas(16) LeafOffset {
  std::int16_t u, v;
  float unused[2], cull_radius2;  // d²
};

template <bool has_radius = false>
[[gnu::always_inline]] inline LeafOffset leaf_offset(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 at = offset_from_ray<has_radius>(leaf, ray);
  const __m128 cull_radius2 =
      _mm_min_ps(__m128(at * at), _mm_set1_ps(0x1p31f - 128.0f));  // an upper bound of all squares
  const __m128i whole = _mm_cvttps_epi32(__m128(at));
  LeafOffset offset;
  const __m128 all =
      _mm_shuffle_ps(_mm_castsi128_ps(_mm_packs_epi32(whole, whole)), cull_radius2, _MM_SHUFFLE(2, 2, 0, 0));
  std::memcpy(&offset, &all, sizeof offset);
  return offset;
}

/// A mask of the pieces that may come within the culling radius of the ray's line. In most leaves no piece's line does,
/// but in too many one does: a branch on that costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const ProjectedRay& ray, const WideLeaf& leaf,
                                                      const LeafOffset& offset) {
  // The components of an axis in pairs of bytes: x and y; z and 0; 0 and z. And the projection of the leaf's origin.
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
  const Axis u(ray.packed[0], offset.u), v(ray.packed[1], offset.v);
  const Int32s cull_radius2 = Int32s::of(offset.cull_radius2);
  Int16s near[kSimdWidth / Int16s::kCount];
  for (int i = 0; i < kSimdWidth / Int16s::kCount; ++i) {
    const std::uint8_t* const ends = leaf.ends + i * int(sizeof(Int16s));
    const Int16s zs = Int16s::load(ends + end_byte(0, 2, 0)), as = Int16s::load(ends),
                 cs = Int16s::load(ends + end_byte(1, 0, 0));
    const Int16s au = u.of_first(as, zs), av = v.of_first(as, zs);
    const Int16s cu = u.of_second(cs, zs), cv = v.of_second(cs, zs);
    const Int16s back_u = au - cu, wv = cv - av;  // w = c − a with u negated, so that the cross product is a sum
    const auto half = [&]<bool low>() __attribute__((always_inline)) {
      const Int16Pairs a = Int16Pairs::of<low>(au, av), c = Int16Pairs::of<low>(cu, cv),
                       w = Int16Pairs::of<low>(wv, back_u);
      const Int32s aa = dot(a, a), cc = dot(c, c), ww = dot(w, w), cross = dot(a, w);
      // If a piece is a point, w² = 0: the second test fails, and the ends decide. Truncating d² and comparing with
      // < make it smaller by at most 2; the slack of 0.89 quanta has more than 200 to spare.
      return (min(aa, cc) < cull_radius2) | ((abs(aa - cc) < ww) & is_square_within(cross, ww, offset.cull_radius2));
    };
    near[i] = join(half.template operator()<true>(), half.template operator()<false>());
  }
  return bits_of(near) & ((1u << leaf.n_refs) - 1);
}

#else

/// The offset of a leaf from a ray. All instructions of the test depend on it, so kernels compute offsets ahead: then
/// the processor overlaps the tests.
struct alignas(16) LeafOffset {
  using Start = std::conditional_t<kIntegerAxes, std::int32_t, float>;
  Start u, v;
  float unused, cull_radius2;  // d²
};

template <bool has_radius = false>
[[gnu::always_inline]] inline LeafOffset leaf_offset(const WideLeaf& leaf, const ProjectedRay& ray) {
  const FloatX4 at = offset_from_ray<has_radius>(leaf, ray);
  // If d is twice as large as the leaf, all pieces that can be within it pass.
  constexpr float kPassAll = 512.0f * kAxisLength, kHuge = 1e30f;
  const FloatX4 cull_radius2 = max(at * at, fma(at, broadcast_x4(kHuge), broadcast_x4(-kHuge * kPassAll)));
  LeafOffset offset;
  static_assert(sizeof offset == sizeof at);
  FloatX4 all;
  // An origin that is very far from the ray overflows an integer, or a float when squared. If the leaf is within
  // the culling radius nevertheless, all of its pieces pass.
  if constexpr (kIntegerAxes)
    all = FloatX4(__builtin_convertvector(at, IntX4));
  else
    all = min(max(at, broadcast_x4(-1e15f)), broadcast_x4(1e15f));
  all = __builtin_shufflevector(all, cull_radius2, 0, 1, 6, 6);
  std::memcpy(&offset, &all, sizeof offset);
  return offset;
}

/// A mask of the pieces that may come within the culling radius of the ray's line. In most leaves no piece's line does,
/// but in too many one does: a branch on that costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const ProjectedRay& ray, const WideLeaf& leaf,
                                                      const LeafOffset& offset) {
  using F = FloatX16;
  // Unless all pieces pass, the rounding of squares is less than kRounding.
  constexpr float kRounding = 0.5f * kAxisLength * kAxisLength, kTiny = 1e-30f;
  const F cull_radius2 = offset.cull_radius2;
  const LeafPoints a = LeafPoints::of<0>(leaf.ends), c = LeafPoints::of<1>(leaf.ends);
  const ProjectionAxis u(ray.x[0], ray.y[0], ray.z[0], ray.packed[0]), v(ray.x[1], ray.y[1], ray.z[1], ray.packed[1]);
  const F au = a.project(u, offset.u), av = a.project(v, offset.v);
  const F cu = c.project(u, offset.u), cv = c.project(v, offset.v);
  const F back_u = au - cu, wv = cv - av;  // w = c − a with u negated, so that the cross product is a sum
  const F cross = fma(au, wv, av * back_u);
  const F ww = fma(back_u, back_u, wv * wv);
  // Each value is a bound minus what it bounds, so that signs decide. That needs few comparisons, all independent.
  const F a_near = fnma(au, au, fnma(av, av, cull_radius2)), c_near = fnma(cu, cu, fnma(cv, cv, cull_radius2));
  // The line fails if the piece is a point: then the ends decide.
  const F line = fnma(cross, cross, fma(ww, cull_radius2, F(-kTiny)));
  // The foot of the perpendicular is between the ends.
  const F inside = (ww + F(kRounding)) - abs(a_near - c_near);
  return nonnegative_mask(line, inside, a_near, c_near) & ((1u << leaf.n_refs) - 1);
}

#endif

}  // namespace fastlines
