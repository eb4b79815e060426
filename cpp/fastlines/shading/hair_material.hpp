// The material of a fibre, as its lobes need it. HairMaterial in Python has the parameters and what they mean.
#pragma once

#include <array>
#include <cmath>

namespace fastlines {

/// The numbers of a material in float64: σ_a for red, green and blue, η, four variances, four tilts and the logistic
/// scale.
using HairNumbers = std::array<double, 13>;

/// What the lobes R, TT, TRT and the rest, p = 0 to 3, have in common at all points of a material.
struct HairMaterial {
  static constexpr int kLobes = 4;

  struct Lobe {
    float sin_tilt, cos_tilt;
    float variance;          ///< v, of the density along the fibre
    float inverse_variance;  ///< 1 / v
    float opposite;          ///< exp(−2 / v), the density opposite to the peak, in parts of the peak
    float scale;             ///< 1 / (v (1 − exp(−2 / v)))
  };

  float sigma_a[3];
  float eta, inverse_eta;
  Lobe lobes[kLobes];
  float logistic_scale;    ///< s, in radians
  float inverse_logistic;  ///< 1 / s
  float logistic_mass;     ///< how much of the logistic distribution is in −π…π
  float logistic_density;  ///< 1 / (s mass)

  explicit HairMaterial(const HairNumbers& numbers) {
    for (int channel = 0; channel < 3; ++channel) sigma_a[channel] = float(numbers[channel]);
    eta = float(numbers[3]);
    inverse_eta = float(1.0 / numbers[3]);
    for (int p = 0; p < kLobes; ++p) {
      const double v = numbers[4 + p], tilt = numbers[8 + p];
      lobes[p] = {float(std::sin(tilt)), float(std::cos(tilt)),     float(v),
                  float(1.0 / v),        float(std::exp(-2.0 / v)), float(1.0 / (v * -std::expm1(-2.0 / v)))};
    }
    const double s = numbers[12], mass = std::tanh(0.5 * 3.14159265358979323846 / s);
    logistic_scale = float(s);
    inverse_logistic = float(1.0 / s);
    logistic_mass = float(mass);
    logistic_density = float(1.0 / (s * mass));
  }
};

}  // namespace fastlines
