// The test that culls the pieces of a leaf: which of them may come within reach of a ray's line?
//
// They are seen along the ray, in a plane across it: the ray is the origin, a piece a line from a to c, and all is in
// quanta of the leaf. Rounding an end to a byte moves it by at most √3/2 quanta, and with it every point of the piece
// by no more; the rest of 0.89 is for the rounding of the arithmetic.
//
// Where the plane's axes have to be whole numbers (simd/points.hpp), they are those nearest to 126 times the true ones,
// U = U' + (U·r)·r with U' across the ray. A leaf's origin is seen along U', its points along U, less what the middle
// of the leaf is off by. So a point is off by |U·r| times how far along the ray it lies from the middle, at most
// 127.5·(|r_x| + |r_y| + |r_z|). And U' and V' make a circle an ellipse, of which the longer axis counts. All this
// makes reach larger, by half a quantum in the mean, by 2.2 at most; nothing is lost.
#pragma once

#include "../layout/wide.hpp"
#include "../query/ray.hpp"
#include "../simd/four.hpp"
#include "../simd/points.hpp"

namespace fastlines {

/// How long the axes are.
inline constexpr float kLength = kWholeAxes ? 126.0f : 1.0f;

/// A ray as leaves see it, or sixteen: N is float or Float16. What is found of a leaf at once stands side by side.
template <class N>
struct AcrossOf {
  N x[2], y[2], z[2];  // the axes across
  N packed[2];         // and as bytes
  N away[4], rest[4];  // where the leaf's origin lies along both, and how near counts; the last is nothing

  AcrossOf() = default;
  AcrossOf(const N (&o)[3], const N (&r)[3], const N (&u)[3], const N (&v)[3], N reach) {
    N length = 1.0f, astray = 0.0f;  // of the axes; how far points may be off
    for (int i = 0; i < 2; ++i) {
      const N(&axis)[3] = i == 0 ? u : v;
      x[i] = axis[0] * N(kLength);
      y[i] = axis[1] * N(kLength);
      z[i] = axis[2] * N(kLength);
      packed[i] = take_axis(x[i], y[i], z[i]);
      rest[i] = 0.0f;
    }
    if constexpr (kWholeAxes) {
      N along[2];
      for (int i = 0; i < 2; ++i) {
        along[i] = fma(x[i], r[0], fma(y[i], r[1], z[i] * r[2]));
        x[i] = x[i] - along[i] * r[0];
        y[i] = y[i] - along[i] * r[1];
        z[i] = z[i] - along[i] * r[2];
        rest[i] = along[i] * (N(-127.5f) * (r[0] + r[1] + r[2]));
      }
      const auto dot = [&](int i, int j) { return fma(x[i], x[j], fma(y[i], y[j], z[i] * z[j])); };
      length = sqrt(max(dot(0, 0), dot(1, 1)) + abs(dot(0, 1))) * N(1.0f + 1e-6f);
      astray = sqrt(fma(along[0], along[0], along[1] * along[1])) * N(127.5f) * (abs(r[0]) + abs(r[1]) + abs(r[2])) +
               N(2.0f);  // truncation
    }
    for (int i = 0; i < 2; ++i) away[i] = N(0.0f) - fma(x[i], o[0], fma(y[i], o[1], z[i] * o[2]));
    away[2] = reach * length;
    rest[2] = fma(N(0.89f), length, astray);
    away[3] = rest[3] = 0.0f;
  }

  Axis axis(int i) const { return {x[i], y[i], z[i], packed[i]}; }
};
using Across = AcrossOf<float>;

/// Where a leaf lies beside a ray. To find it ahead of the test, for many leaves, lets the processor work on more of
/// them at a time: what waits for it are all instructions of the test.
struct alignas(16) LeafPlace {
  using Start = std::conditional_t<kWholeAxes, std::int32_t, float>;
  Start u, v;
  float unused, near2;  // the square of how near counts
};

[[gnu::always_inline]] inline LeafPlace place_of(const WideLeaf& leaf, const Across& ray) {
  const Float4 beside = fma(four(leaf.org[2]), two(ray.z),
                            fma(four(leaf.org[1]), two(ray.y), fma(four(leaf.org[0]), two(ray.x), four(ray.away))));
  const Float4 at = fma(beside, four(leaf.per_scale), four(ray.rest));
  // Where reach is twice as large as the leaf, all pass that can be in reach.
  constexpr float kAll = 512.0f * kLength, kMuch = 1e30f;
  const Float4 near2 = max(at * at, fma(at, four(kMuch), four(-kMuch * kAll)));
  LeafPlace place;
  static_assert(sizeof place == sizeof at);
  Float4 all;
  // What lies so far beyond the leaf is too large for a whole number, or to be squared; if it is in reach all the same,
  // all pass.
  if constexpr (kWholeAxes)
    all = Float4(__builtin_convertvector(at, Int4));
  else
    all = min(max(at, four(-1e15f)), four(1e15f));
  all = __builtin_shufflevector(all, near2, 0, 1, 6, 6);
  std::memcpy(&place, &all, sizeof place);
  return place;
}

/// The pieces that may come within reach of the ray's line. Most leaves fail at the line already, but too many do not:
/// a branch there costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const Across& ray, const WideLeaf& leaf, const LeafPlace& place) {
  using F = Float16;
  // Where not all pass, squares are rounded by less than `grain`.
  constexpr float kGrain = 0.5f * kLength * kLength, kTiny = 1e-30f;
  const F near2 = place.near2;
  const Points16 a = Points16::of<0>(leaf.ends), c = Points16::of<3>(leaf.ends);
  const Axis u = ray.axis(0), v = ray.axis(1);
  const F au = a.along(u, place.u), av = a.along(v, place.v);
  const F cu = c.along(u, place.u), cv = c.along(v, place.v);
  const F back_u = au - cu, wv = cv - av;  // c − a, but u the other way: cross is a sum
  const F cross = fma(au, wv, av * back_u);
  const F ww = fma(back_u, back_u, wv * wv);
  // Each is what a bound exceeds it by, so that signs decide: comparisons are few, and none waits for another.
  const F a_near = fnma(au, au, fnma(av, av, near2)), c_near = fnma(cu, cu, fnma(cv, cv, near2));
  const F line = fnma(cross, cross, fma(ww, near2, F(-kTiny)));  // not where a piece is a point: there the ends decide
  const F inside = (ww + F(kGrain)) - abs(a_near - c_near);      // the foot of the perpendicular from the origin
  return not_negative(line, inside, a_near, c_near) & ((1u << leaf.n_refs) - 1);
}

}  // namespace fastlines
