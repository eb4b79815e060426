// The callbacks of user geometry, which test all rays of a packet at once. Compiled once for each instruction set, with
// fused multiply-adds, so that Embree is not held back.
//
// The distance is that of cpp/fastlines/primitives/segment_test.hpp, without the frame and the basis. Directions have
// unit length. With p = P − o, the parts of p and e perpendicular to the ray are
//
//     a = p − (p·r) r,   b = e − (e·r) r;   s = −a·b / b·b, clamped to [0, 1];   t = p·r + s·e·r.
//
// Most calls end after the distance of the two lines, |p·(e × r)| / |e × r|, a lower bound for the distance of ray and
// segment.
#include "embree_user.hpp"

#include <limits>

#include "lanes.hpp"

#ifndef PEER_ISA
#define PEER_ISA portable
#endif

namespace fastlines::peers {
namespace {

enum class Query { first, any, all };

/// Tests W rays, from lane `from` of a packet of n, against a piece.
template <int W, Query kQuery>
void test(const CallbackArguments& args, unsigned n, unsigned from) {
  using F = typename Lanes<W>::F;
  using I = typename Lanes<W>::I;
  auto& batch = static_cast<Batch&>(*args.context);
  const Piece& piece = batch.pieces[args.prim];
  const auto at = [&](unsigned field) { return args.rays + field * n + from; };
  const auto field = [&](unsigned k) { return load<F>(at(k)); };
  I valid = load<I>(args.valid + from);

  // Reject rays by the distance of the lines.
  const F rx = field(kDirection), ry = field(kDirection + 1), rz = field(kDirection + 2);
  const F px = piece.p[0] - field(kOrigin), py = piece.p[1] - field(kOrigin + 1), pz = piece.p[2] - field(kOrigin + 2);
  const float ex = piece.e[0], ey = piece.e[1], ez = piece.e[2];
  const F nx = ey * rz - ez * ry, ny = ez * rx - ex * rz, nz = ex * ry - ey * rx;
  const F pn = px * nx + py * ny + pz * nz;
  const float length2 = ex * ex + ey * ey + ez * ez;
  valid &= as_mask<I>(pn * pn <= (nx * nx + ny * ny + nz * nz) * batch.loose2 + batch.slack2 * length2);
  if (bits(valid) == 0) return;

  // Find the closest approach of the ray's line.
  const F pr = px * rx + py * ry + pz * rz, er = ex * rx + ey * ry + ez * rz;
  const F ax = px - pr * rx, ay = py - pr * ry, az = pz - pr * rz;
  const F bx = ex - er * rx, by = ey - er * ry, bz = ez - er * rz;
  const F bb = bx * bx + by * by + bz * bz, ab = ax * bx + ay * by + az * bz;
  const F zero{}, one = zero + 1.0f;
  const I parallel = as_mask<I>(bb <= zero + 1e-12f * length2);
  F s = blend(parallel, blend(as_mask<I>(er < zero), one, zero), clamp01<I>(-ab / blend(parallel, one, bb)));
  F t = pr + s * er;
  F along = zero;

  // Where its t is outside the ray's bounds, use the bound.
  const F t_min = field(kNear);
  I outside = as_mask<I>(t < t_min);
  F bound = t_min;
  if (batch.bounded) {
    const I over = as_mask<I>(t > zero + batch.t_max);
    bound = blend(over, zero + batch.t_max, bound);
    outside |= over;
  }
  if (bits(outside & valid)) {
    t = blend(outside, bound, t);
    const F all2 = bb + er * er;
    const F moved = clamp01<I>(-(ab + (pr - t) * er) / blend(as_mask<I>(all2 > zero), all2, one));
    s = blend(outside, moved, s);
    along = blend(outside, pr - t + s * er, zero);
  }
  const F x = ax + s * bx, y = ay + s * by, z = az + s * bz;
  valid &= as_mask<I>(x * x + y * y + z * z + along * along <= zero + batch.radius2);

  // Record the hits for the query.
  const std::uint32_t prim = piece.owner.prim;
  if constexpr (kQuery == Query::first) {
    const F best = field(kFar);
    unsigned* hits = reinterpret_cast<unsigned*>(args.rays + 12 * n);
    for (unsigned left = bits(valid & as_mask<I>(t <= best)); left; left &= left - 1) {
      const unsigned i = unsigned(__builtin_ctz(left)), lane = from + i;
      float hit_t;
      if constexpr (W == 1)
        hit_t = t;
      else
        hit_t = t[i];
      float& far = args.rays[kFar * n + lane];
      unsigned& best_prim = hits[kPrim * n + lane];
      if (hit_t == far && hits[kGeom * n + lane] != kInvalid && best_prim < prim) continue;
      far = hit_t;
      best_prim = prim;
      hits[kGeom * n + lane] = args.geom;
      hits[kInstance * n + lane] = kInvalid;
    }
  } else if constexpr (kQuery == Query::any) {
    const F none = zero - std::numeric_limits<float>::infinity();
    const F far = blend(valid, none, field(kFar));
    std::memcpy(at(kFar), &far, sizeof far);
  } else {
    unsigned left = bits(valid);
    if (left == 0) return;
    // Only the piece that owns the s of the closest approach reports the hit.
    const Owner owner = piece.owner;
    const float s0 = owner.is_first() ? 0.0f : float(owner.k) / owner.m;
    const float s1 = owner.is_last() ? 2.0f : float(owner.k + 1) / owner.m;
    for (; left; left &= left - 1) {
      const unsigned i = unsigned(__builtin_ctz(left));
      float hit_s, hit_t;
      if constexpr (W == 1)
        hit_s = s, hit_t = t;
      else
        hit_s = s[i], hit_t = t[i];
      if (hit_s < s0 || hit_s >= s1) continue;
      HitBuffer& hits = *batch.hits;
      if (hits.at == hits.end) hits.grow();
      *hits.at++ = {reinterpret_cast<const std::uint32_t*>(at(kId))[i], prim, hit_t};
    }
  }
}

template <Query kQuery>
void callback(const CallbackArguments* args) {
#ifdef __AVX512F__
  if (args->n == 16) return test<16, kQuery>(*args, 16, 0);
#endif
  switch (args->n) {
    case 1:
      return test<1, kQuery>(*args, 1, 0);
    case 4:
      return test<4, kQuery>(*args, 4, 0);
    default:
      for (unsigned from = 0; from < args->n; from += 8) test<8, kQuery>(*args, args->n, from);
  }
}

}  // namespace

namespace PEER_ISA {
Callbacks callbacks() {
  return {callback<Query::first>, callback<Query::any>, callback<Query::all>, gather_callback()};
}
}  // namespace PEER_ISA

}  // namespace fastlines::peers
