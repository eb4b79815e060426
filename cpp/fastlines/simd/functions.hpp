// Elementary functions of 16 numbers, from arithmetic alone. Their errors are below 3·10⁻⁷, relative for exp, log and
// angles, and absolute for sine and cosine. The approximations are those of S. Moshier's Cephes library (single
// precision).
#pragma once

#include "lanes.hpp"

namespace fastlines {

inline constexpr float kPi = 3.14159265358979323846f;

/// eˣ; 0 below −87.
inline FloatLanes exp(const FloatLanes& x) {
  const FloatLanes bounded = clamp(x, -87.0f, 88.0f), n = round(bounded * 1.44269504f);
  const FloatLanes r = (bounded - n * 0.693359375f) - n * -2.12194440e-4f;
  FloatLanes p = r * 1.9875691500e-4f + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * (r * r) + r + 1.0f;
  const FloatLanes power = bit_cast<float>((to_int(n) + 127) << 23);
  return select(x < -87.0f, FloatLanes(0.0f), p * power);
}

/// The natural logarithm of normal positive numbers.
inline FloatLanes log(const FloatLanes& x) {
  // Write x = m·2ⁿ with m in [√½, √2).
  const IntLanes bits = bit_cast<std::int32_t>(x);
  IntLanes exponent = (bits >> 23) - 126;
  FloatLanes m = bit_cast<float>((bits & 0x007f'ffff) | 0x3f00'0000);
  const IntLanes low = m < FloatLanes(0.707106781f);
  exponent += low;  // a mask is −1
  m = select(low, m + m, m) - 1.0f;
  const FloatLanes n = to_float(exponent), square = m * m;
  FloatLanes p = m * 7.0376836292e-2f - 1.1514610310e-1f;
  p = p * m + 1.1676998740e-1f;
  p = p * m - 1.2420140846e-1f;
  p = p * m + 1.4249322787e-1f;
  p = p * m - 1.6668057665e-1f;
  p = p * m + 2.0000714765e-1f;
  p = p * m - 2.4999993993e-1f;
  p = p * m + 3.3333331174e-1f;
  return ((p * m * square + n * -2.12194440e-4f) - 0.5f * square) + m + n * 0.693359375f;
}

/// 1 / √x of normal positive numbers, in less time than a division and a root take.
inline FloatLanes inverse_sqrt(const FloatLanes& x) {
  // Halve the exponent, and improve the result three times by Newton's method.
  FloatLanes y = bit_cast<float>(0x5f37'59df - (bit_cast<std::int32_t>(x) >> 1));
  const FloatLanes half = 0.5f * x;
  for (int step = 0; step < 3; ++step) y = y + y * (0.5f - half * y * y);
  return y;
}

/// xʸ for x ≥ 0; 0 where x is below the least normal number.
inline FloatLanes pow(const FloatLanes& x, const FloatLanes& y) {
  const float least = 1.17549435e-38f;
  return select(x < least, select(y > 0.0f, FloatLanes(0.0f), FloatLanes(1.0f)),
                exp(y * log(max(x, FloatLanes(least)))));
}

struct SinCos {
  FloatLanes sin, cos;
};

/// The sine and the cosine of |x| < 8000.
inline SinCos sincos(const FloatLanes& x) {
  const FloatLanes n = round(x * 0.636619772f);
  const FloatLanes r = ((x - n * 1.5703125f) - n * 4.83751297e-4f) - n * 7.54978942e-8f;
  const FloatLanes square = r * r;
  FloatLanes s = square * -1.9515295891e-4f + 8.3321608736e-3f;
  s = s * square - 1.6666654611e-1f;
  s = s * square * r + r;
  FloatLanes c = square * 2.443315711809948e-5f - 1.388731625493765e-3f;
  c = c * square + 4.166664568298827e-2f;
  c = c * square * square - 0.5f * square + 1.0f;
  const IntLanes quadrant = to_int(n), odd = (quadrant & 1) != 0;
  const FloatLanes sine = select(odd, c, s), cosine = select(odd, s, c);
  return {bit_cast<float>(bit_cast<std::int32_t>(sine) ^ ((quadrant & 2) << 30)),
          bit_cast<float>(bit_cast<std::int32_t>(cosine) ^ (((quadrant + 1) & 2) << 30))};
}

/// The angle of (x, y), from −π to π; 0 for (0, 0).
inline FloatLanes atan2(const FloatLanes& y, const FloatLanes& x) {
  const FloatLanes along = abs(x), up = abs(y);
  const IntLanes steep = along < up;
  const FloatLanes small = select(steep, along, up), large = select(steep, up, along);
  // Take the arc tangent of small / large, or of what exceeds 45°.
  const IntLanes beyond = small > 0.414213562f * large;
  const FloatLanes down = select(beyond, small - large, small), right = select(beyond, small + large, large);
  const FloatLanes z = select(large > 0.0f, down / right, large), square = z * z;
  FloatLanes p = square * 8.05374449538e-2f - 1.38776856032e-1f;
  p = p * square + 1.99777106478e-1f;
  p = p * square - 3.33329491539e-1f;
  FloatLanes angle = p * square * z + z;
  angle = select(beyond, angle + 0.25f * kPi, angle);
  angle = select(steep, 0.5f * kPi - angle, angle);
  angle = select(x < 0.0f, kPi - angle, angle);
  return times_sign(angle, y);
}

/// The arc sine of numbers from −1 to 1.
inline FloatLanes asin(const FloatLanes& x) {
  const FloatLanes size = abs(x);
  const IntLanes steep = size > 0.5f;
  const FloatLanes square = select(steep, 0.5f * (1.0f - size), size * size);
  const FloatLanes z = select(steep, sqrt(max(square, FloatLanes(0.0f))), size);
  FloatLanes p = square * 4.2163199048e-2f + 2.4181311049e-2f;
  p = p * square + 4.5470025998e-2f;
  p = p * square + 7.4953002686e-2f;
  p = p * square + 1.6666752422e-1f;
  const FloatLanes angle = p * square * z + z;
  return times_sign(select(steep, 0.5f * kPi - 2.0f * angle, angle), x);
}

/// The arc cosine of numbers from −1 to 1.
inline FloatLanes acos(const FloatLanes& x) {
  const FloatLanes size = abs(x);
  const FloatLanes near = 2.0f * asin(sqrt(max(0.5f * (1.0f - size), FloatLanes(0.0f))));
  return select(size > 0.5f, select(x < 0.0f, kPi - near, near), 0.5f * kPi - asin(x));
}

}  // namespace fastlines
