// The densities of a lobe of hair: M_p along the fibre and N_p around it. Modules `longitudinal` and `azimuthal` of
// fastlines.rendering.hair have the formulas and where they are from.
#pragma once

#include "functions.hpp"
#include "hair_material.hpp"

namespace fastlines {

/// M_p, the density of sin θi, for the inclination of the outgoing direction as the scales turn it.
inline FloatLanes longitudinal_density(const HairMaterial::Lobe& lobe, const FloatLanes& sin_i, const FloatLanes& cos_i,
                                       const FloatLanes& sin_o, const FloatLanes& cos_o) {
  const FloatLanes across = cos_i - cos_o, along = sin_i + sin_o, x = cos_i * cos_o * lobe.inverse_variance;
  // Take I0(x) below 3.75, and exp(−x) I0(x) above, by the polynomials of Abramowitz and Stegun.
  const FloatLanes border = 3.75f, low = min(x, border) * (1.0f / 3.75f), high = border / max(x, border);
  const FloatLanes square = low * low;
  FloatLanes small = square * 0.0045813f + 0.0360768f;
  small = small * square + 0.2659732f;
  small = small * square + 1.2067492f;
  small = small * square + 3.0899424f;
  small = small * square + 3.5156229f;
  small = small * square + 1.0f;
  FloatLanes large = high * 0.00392377f - 0.01647633f;
  large = large * high + 0.02635537f;
  large = large * high - 0.02057706f;
  large = large * high + 0.00916281f;
  large = large * high - 0.00157565f;
  large = large * high + 0.00225319f;
  large = large * high + 0.01328592f;
  large = large * high + 0.39894228f;
  const IntLanes is_small = x < border;
  const FloatLanes bessel = select(is_small, small, large * sqrt(high * (1.0f / 3.75f)));
  const FloatLanes away = (across * across + along * along) * (-0.5f * lobe.inverse_variance);
  return exp(away - select(is_small, x, FloatLanes(0.0f))) * bessel * lobe.scale;
}

/// Angles turned into −π…π.
inline FloatLanes turned(const FloatLanes& x) {
  const FloatLanes n = round(x * (0.5f / kPi));
  return (x - n * 6.28125f) - n * 1.9353071795864769e-3f;
}

/// N_p, the density of an azimuth's distance from the perfect one: the trimmed logistic.
inline FloatLanes azimuthal_density(const HairMaterial& material, const FloatLanes& distance) {
  const FloatLanes fall = exp(abs(turned(distance)) * -material.inverse_logistic), sum = 1.0f + fall;
  return fall / (sum * sum) * material.logistic_density;
}

}  // namespace fastlines
