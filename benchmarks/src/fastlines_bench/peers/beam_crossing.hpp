// What a photon beam adds to a camera ray, as the peers of a gather compute it: W pairs of a ray and a beam at once.
//
// A ray o + t·r, where r has unit length, and a beam p + u·e, where u is in [0, 1]. With n = e × r and Δ = p − o, the
// lines are nearest at
//
//     t = −((Δ × e)·n)/|n|²,   u = −((Δ × r)·n)/|n|²,   where their distance is |Δ·n|/|n|,   and sin θ = |n|/|e|.
//
// The beam adds its power times K / sin θ · exp(−σ t − σ′ u |e|) · p(cos θ) (Jarosz et al., "Progressive Photon Beams",
// 2011), where K = 3/(4R)·(1 − (distance/R)²) is the kernel of Epanechnikov, which is 0 at the edge: peers whose
// distances differ by rounding have nearly the same sums. p is the phase function of Henyey and Greenstein.
#pragma once

#include <numbers>

#include "gather.hpp"
#include "lanes.hpp"

namespace {

using fastlines::peers::Gather;

/// sin² θ below which a pair counts as parallel.
constexpr float kParallel = 0x1p-40f;

/// The largest u of a beam that is not its end.
constexpr float kLast = 0x1.fffffep-1f;

template <class F>
F dot(const F (&x)[3], const F (&y)[3]) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

template <class F>
void cross(const F (&x)[3], const F (&y)[3], F (&product)[3]) {
  for (int k = 0; k < 3; ++k) product[k] = x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3];
}

/// Finds the lanes in which the beam adds to the ray, and by which factor.
///
/// @param valid  The lanes to test.
/// @param delta  p − o.
/// @param r, e  The ray's unit direction; the beam's edge.
/// @param u0, u1  The part of the beam that counts, without u0.
/// @param weight  The factors of the lanes that the function returns.
template <class F, class I>
I crossing(I valid, const F (&delta)[3], const F (&r)[3], const F (&e)[3], const F& u0, const F& u1,
           const Gather& gather, F& weight) {
  F n[3], across[3], along[3];
  cross(e, r, n);
  const F zero{}, pn = dot(delta, n), nn = dot(n, n);
  valid &= as_mask<I>(pn * pn <= nn * (gather.radius * gather.radius));
  if (bits(valid) == 0) return valid;

  const F ee = dot(e, e);
  valid &= as_mask<I>(nn > ee * kParallel);
  const F inverse = 1.0f / blend(valid, nn, zero + 1.0f);
  cross(delta, r, across);
  cross(delta, e, along);
  const F u = -dot(across, n) * inverse, t = -dot(along, n) * inverse;
  valid &= as_mask<I>(u > u0) & as_mask<I>(u <= u1);
  valid &= as_mask<I>(t > zero + gather.t_min) & as_mask<I>(t < zero + gather.t_max);
  if (bits(valid) == 0) return valid;

  const F length = square_root(ee);
  const F kernel = 0.75f / gather.radius * (1.0f - pn * pn * inverse * (1.0f / (gather.radius * gather.radius)));
  const F transmittance = exponential<I>(-gather.sigma * t - gather.line_sigma * u * length);
  const float g = gather.g, scale = (1 - g * g) / (4 * std::numbers::pi_v<float>);
  const F turn = 1.0f + g * g + 2 * g * dot(r, e) / length;  // cos θ = −(r·e)/|e|: the light leaves towards o
  const F phase = scale / (turn * square_root(turn));
  weight = kernel * length * square_root(inverse) * transmittance * phase;
  return valid;
}

}  // namespace
