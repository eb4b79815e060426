// The densities of a lobe of hair: M_p along the fibre and N_p around it. Modules `longitudinal` and `azimuthal` of
// fastlines.rendering.hair have the formulas and where they are from.
#pragma once

#include "../simd/functions.hpp"
#include "hair_material.hpp"

namespace fastlines {

/// eˣ of x ≤ 0, and 0 below −30: a product of three is then no denormal number, with which arithmetic is slow.
inline FloatLanes exp_or_none(const FloatLanes& x) { return select(x < -30.0f, FloatLanes(0.0f), exp(x)); }

/// I0(x) for x up to 3.75, and √x exp(−x) I0(x) above: the polynomials of Abramowitz and Stegun, 9.8.1 and 9.8.2.
inline FloatLanes small_i0(const FloatLanes& x) {
  const FloatLanes y = x * (1.0f / 3.75f), square = y * y;
  FloatLanes p = square * 0.0045813f + 0.0360768f;
  p = p * square + 0.2659732f;
  p = p * square + 1.2067492f;
  p = p * square + 3.0899424f;
  p = p * square + 3.5156229f;
  return p * square + 1.0f;
}
inline FloatLanes large_i0(const FloatLanes& inverse) {
  const FloatLanes y = 3.75f * inverse;
  FloatLanes p = y * 0.00392377f - 0.01647633f;
  p = p * y + 0.02635537f;
  p = p * y - 0.02057706f;
  p = p * y + 0.00916281f;
  p = p * y - 0.00157565f;
  p = p * y + 0.00225319f;
  p = p * y + 0.01328592f;
  return p * y + 0.39894228f;
}

/// M_p, the density of sin θi, for the inclination of the outgoing direction as the scales turn it.
inline FloatLanes longitudinal_density(const HairMaterial::Lobe& lobe, const FloatLanes& sin_i, const FloatLanes& cos_i,
                                       const FloatLanes& sin_o, const FloatLanes& cos_o) {
  const FloatLanes across = cos_i - cos_o, along = sin_i + sin_o, x = cos_i * cos_o * lobe.inverse_variance;
  const FloatLanes away = (across * across + along * along) * (-0.5f * lobe.inverse_variance);
  // Where x is large, exp(−x) is a factor of I0 already. Most lobes are all of one kind.
  const FloatLanes border = 3.75f;
  const IntLanes is_large = x > border;
  if (!any(is_large)) return exp_or_none(away - x) * small_i0(x) * lobe.scale;
  const FloatLanes root = inverse_sqrt(max(x, border)), large = large_i0(root * root) * root;
  if (!any(x <= border)) return exp_or_none(away) * large * lobe.scale;
  const FloatLanes bessel = select(is_large, large, small_i0(min(x, border)));
  return exp_or_none(away - select(is_large, FloatLanes(0.0f), x)) * bessel * lobe.scale;
}

/// Angles turned into −π…π.
inline FloatLanes turned(const FloatLanes& x) {
  const FloatLanes n = round(x * (0.5f / kPi));
  return (x - n * 6.28125f) - n * 1.9353071795864769e-3f;
}

/// N_p, the density of an azimuth's distance from the perfect one: the trimmed logistic.
inline FloatLanes azimuthal_density(const HairMaterial& material, const FloatLanes& distance) {
  const FloatLanes fall = exp_or_none(abs(turned(distance)) * -material.inverse_logistic), sum = 1.0f + fall;
  return fall / (sum * sum) * material.logistic_density;
}

}  // namespace fastlines
