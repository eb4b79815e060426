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

#include <limits>

#include "../layout/wide.hpp"
#include "../query/ray.hpp"
#include "../simd/four.hpp"
#include "../simd/points.hpp"

namespace fastlines {

/// How long the axes are.
inline constexpr float kLength = kWholeAxes ? 126.0f : 1.0f;

/// A ray as leaves see it.
struct Across {
  // Three numbers are found of a leaf at once: where its origin lies along both axes, and how near counts.
  Float4 x, y, z, away, rest;
  Axis u, v;

  Across() = default;
  Across(const Vec3& o, const Vec3& r, const Vec3& u_, const Vec3& v_, float reach)
      : x{u_[0], v_[0]}, y{u_[1], v_[1]}, z{u_[2], v_[2]} {
    float length = 1.0f, astray = 0.0f;  // of the axes; how far points may be off
    rest = Float4{};
    x *= four(kLength);
    y *= four(kLength);
    z *= four(kLength);
    take_axes(x, y, z, u, v);
    if constexpr (kWholeAxes) {
      const Float4 rx = four(r[0]), ry = four(r[1]), rz = four(r[2]);
      const Float4 along = x * rx + y * ry + z * rz;
      x -= along * rx;
      y -= along * ry;
      z -= along * rz;
      rest = along * four(-127.5f * (r[0] + r[1] + r[2]));
      const Float4 squares = x * x + y * y + z * z;
      const float both = x[0] * x[1] + y[0] * y[1] + z[0] * z[1];
      length = std::sqrt(max(squares[0], squares[1]) + abs(both)) * (1.0f + 1e-6f);
      astray = std::sqrt(along[0] * along[0] + along[1] * along[1]) * 127.5f * (abs(r[0]) + abs(r[1]) + abs(r[2])) +
               2.0f;  // truncation
    }
    away = -(x * four(o[0]) + y * four(o[1]) + z * four(o[2]));
    away[2] = reach * length;
    rest[2] = 0.89f * length + astray;
  }
};

/// Where a leaf lies beside a ray. To find it ahead of the test, for many leaves, lets the processor work on more of
/// them at a time: what waits for it are all instructions of the test.
struct alignas(16) LeafPlace {
  using Start = std::conditional_t<kWholeAxes, std::int32_t, float>;
  Start u, v;
  float near, unused;
};

[[gnu::always_inline]] inline LeafPlace place_of(const WideLeaf& leaf, const Across& ray) {
  const Float4 beside =
      fma(four(leaf.org[2]), ray.z, fma(four(leaf.org[1]), ray.y, fma(four(leaf.org[0]), ray.x, ray.away)));
  const Float4 at = fma(beside, four(leaf.per_scale), ray.rest);
  LeafPlace place;
  static_assert(sizeof place == sizeof at);
  if constexpr (kWholeAxes) {
    // Too large for that is what lies far beyond the leaf; if it is in reach all the same, all pass.
    const Int4 whole = __builtin_convertvector(at, Int4);
    std::memcpy(&place, &whole, sizeof place);
  } else {
    std::memcpy(&place, &at, sizeof place);
  }
  place.near = at[2];
  return place;
}

/// The pieces that may come within reach of the ray's line. Most leaves fail at the line already, but too many do not:
/// a branch there costs more than it saves.
[[gnu::always_inline]] inline std::uint32_t cull_leaf(const Across& ray, const WideLeaf& leaf, const LeafPlace& place) {
  using F = Float16;
  // Where reach is twice as large as the leaf, all pass. Below that, squares are rounded by less than `grain`.
  constexpr float kAll = 512.0f * kLength, kGrain = 0.5f * kLength * kLength;
  const F near2 = place.near < kAll ? place.near * place.near : std::numeric_limits<float>::infinity();
  const Points16 a = Points16::of<0>(leaf.ends), c = Points16::of<3>(leaf.ends);
  const F au = a.along(ray.u, place.u), av = a.along(ray.v, place.v);
  const F cu = c.along(ray.u, place.u), cv = c.along(ray.v, place.v);
  const F back_u = au - cu, wv = cv - av;  // c − a, but u the other way: cross is a sum
  const F cross = fma(au, wv, av * back_u);
  const F ww = fma(back_u, back_u, wv * wv);
  const F aa = fma(au, au, av * av), cc = fma(cu, cu, cv * cv);
  const auto line = cross * cross < ww * near2;        // never where a piece is a point: there the ends decide
  const auto inside = abs(cc - aa) <= ww + F(kGrain);  // the foot of the perpendicular from the origin
  const auto ends = min(aa, cc) <= near2;
  return ((line & inside) | ends).bits() & ((1u << leaf.n_refs) - 1);
}

}  // namespace fastlines
