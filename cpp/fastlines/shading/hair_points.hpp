// The scattering of light by fibres at known offsets from their axes: the near field of Chiang et al. 2016, for 16
// points at a time. Modules `frame`, `attenuation` and `scattering` of fastlines.rendering.hair have the formulas and
// where they are from.
#pragma once

#include "hair_lobes.hpp"

namespace fastlines {

/// The fibre's frame: the tangent, the part of the outgoing direction across it, and the side, tangent × across.
struct FibreFrame {
  Vec3Lanes tangent, across, side;
  FloatLanes sin_o, cos_o;  ///< the inclination of the outgoing direction

  FibreFrame(const Vec3Lanes& to_eye, const Vec3Lanes& along) : tangent(along) {
    sin_o = clamp(dot(to_eye, tangent), -1.0f, 1.0f);
    across = to_eye - sin_o * tangent;
    across = across - dot(across, tangent) * tangent;  // what rounding has left, which is much of a short part
    const FloatLanes length = sqrt(dot(across, across));
    cos_o = min(length, FloatLanes(1.0f));
    // Where light leaves along the tangent, take any direction across it.
    const IntLanes is_along = length < 4.76837158e-7f;  // 4 ε
    across = unit(any(is_along) ? select(is_along, any_across(), across) : across);
    side = cross(tangent, across);
  }

  struct Angles {
    FloatLanes sine, cosine, phi;
  };
  /// The inclination of directions, and their azimuth from the outgoing one.
  Angles angles(const Vec3Lanes& towards) const {
    const FloatLanes x = dot(towards, across), y = dot(towards, side);
    return {clamp(dot(towards, tangent), -1.0f, 1.0f), min(sqrt(x * x + y * y), FloatLanes(1.0f)), atan2(y, x)};
  }

  /// The unit vectors with some inclinations and azimuths.
  Vec3Lanes direction(const FloatLanes& sine, const FloatLanes& phi) const {
    const FloatLanes cosine = sqrt(max((1.0f - sine) * (1.0f + sine), FloatLanes(0.0f)));
    const SinCos turn = sincos(phi);
    return sine * tangent + (cosine * turn.cos) * across + (cosine * turn.sin) * side;
  }

 private:
  /// The tangent × the axis that it is the farthest from.
  Vec3Lanes any_across() const {
    const Vec3Lanes& t = tangent;
    const FloatLanes zero = 0.0f, x = abs(t.x), y = abs(t.y), z = abs(t.z);
    const IntLanes by_x = (x <= y) & (x <= z), by_y = y <= z;
    return select(by_x, Vec3Lanes{zero, t.z, -t.y}, select(by_y, {-t.z, zero, t.x}, {t.y, -t.x, zero}));
  }
};

/// Points of fibres, each with the direction in which light leaves it.
class HairPoints {
 public:
  /// The material must outlive the points. The tangents are unit vectors, and so are the directions towards the eye. h
  /// is the offset from the axis to the side to_eye × tangent, in radii.
  HairPoints(const HairMaterial& material, const Vec3Lanes& to_eye, const Vec3Lanes& tangents, const FloatLanes& h)
      : material_(material), frame_(to_eye, tangents) {
    for (int p = 0; p < HairMaterial::kLobes; ++p) {
      const HairMaterial::Lobe& lobe = material.lobes[p];
      sin_o_[p] = frame_.sin_o * lobe.cos_tilt + frame_.cos_o * lobe.sin_tilt;
      cos_o_[p] = abs(frame_.cos_o * lobe.cos_tilt - frame_.sin_o * lobe.sin_tilt);
    }
    attenuate(clamp(h, -1.0f, 1.0f));
  }

  /// How much of the light from some directions leaves towards the eye: RGB per steradian, cosine included.
  Vec3Lanes evaluate(const Vec3Lanes& towards) const { return value(densities(towards)); }

  /// The density per steradian with which `sample` draws these directions.
  FloatLanes pdf(const Vec3Lanes& towards) const { return density(densities(towards)); }

  struct Sampled {
    Vec3Lanes towards, weight;  ///< the weight is evaluate / pdf
    FloatLanes pdf;
  };
  /// Draw directions, by uniform numbers from 0 to 1: one for the lobe, two for the inclination, one for the azimuth.
  Sampled sample(const FloatLanes (&u)[4]) const {
    // Choose a lobe by its energy.
    const IntLanes after_first = u[0] > shares_[0], after_second = u[0] > shares_[0] + shares_[1],
                   after_third = u[0] > shares_[0] + shares_[1] + shares_[2];
    const auto chosen = [&](auto&& of) {
      return select(after_third, of(3), select(after_second, of(2), select(after_first, of(1), of(0))));
    };
    // Draw the inclination: the angle from the mean direction, and its side. Keep 1 − cos, which is small.
    const FloatLanes opposite = chosen([&](int p) { return FloatLanes(material_.lobes[p].opposite); });
    const FloatLanes variance = chosen([&](int p) { return FloatLanes(material_.lobes[p].variance); });
    const FloatLanes mass = max(u[1] + (1.0f - u[1]) * opposite, FloatLanes(kLeast));
    const FloatLanes fall = clamp(-variance * log(mass), 0.0f, 2.0f);
    const FloatLanes aside = sqrt(fall * (2.0f - fall)) * sincos(2.0f * kPi * u[2]).cos;
    const FloatLanes sine =
        (fall - 1.0f) * chosen([&](int p) { return sin_o_[p]; }) + aside * chosen([&](int p) { return cos_o_[p]; });
    // Draw the azimuth.
    const FloatLanes share = 0.5f + (u[3] - 0.5f) * material_.logistic_mass;
    const FloatLanes odds = log(max(share, FloatLanes(kLeast))) - log(max(1.0f - share, FloatLanes(kLeast)));
    const FloatLanes spread = clamp(odds * material_.logistic_scale, -kPi, kPi), around = 2.0f * kPi * u[3];
    const FloatLanes phi = chosen([&](int p) { return p < kDirected ? perfect_[p] + spread : around; });
    // Weigh the direction as it is rounded.
    Sampled drawn;
    drawn.towards = frame_.direction(clamp(sine, -1.0f, 1.0f), phi);
    const Densities each = densities(drawn.towards);
    drawn.pdf = density(each);
    drawn.weight = 1.0f / max(drawn.pdf, FloatLanes(kTiny)) * value(each);
    return drawn;
  }

 private:
  static constexpr float kLeast = 2e-13f;  ///< the least share of samples: its density is above 0
  static constexpr float kTiny = 1e-30f;   ///< what replaces a divisor of 0
  static constexpr int kDirected = 3;      ///< lobes with a direction; the last one is what remains
  using Densities = std::array<FloatLanes, HairMaterial::kLobes>;

  /// Set the energy of each lobe, and the azimuth in which it leaves the fibre.
  void attenuate(const FloatLanes& h) {
    // Follow the ray into the fibre.
    const FloatLanes one = 1.0f, eta = material_.eta, &sin_o = frame_.sin_o, &cos_o = frame_.cos_o;
    const FloatLanes cosine = cos_o * sqrt((one - h) * (one + h));
    const FloatLanes inside = sqrt(one - (one - cosine * cosine) * (material_.inverse_eta * material_.inverse_eta));
    const FloatLanes s = (cosine - eta * inside) * (eta * cosine + inside);
    const FloatLanes p = (eta * cosine - inside) * (cosine + eta * inside);
    const FloatLanes below = (cosine + eta * inside) * (eta * cosine + inside);
    const FloatLanes reflected = 0.5f * (s * s + p * p) / (below * below), entering = one - reflected;
    const FloatLanes bent = inverse_sqrt(eta * eta - sin_o * sin_o), sin_gamma = h * cos_o * bent;
    // The path's length is that across the fibre over cos θt, the cosine of its inclination, which is 1 / (η bent).
    const FloatLanes length = 2.0f * eta * bent * sqrt((one - sin_gamma) * (one + sin_gamma));

    // Sum the geometric series of the lobes from p = 3 on; its first term is 0 where its ratio is 1.
    reflected_ = reflected;
    const auto channel = [&](int c) {
      const FloatLanes transmitted = exp_or_none(-length * material_.sigma_a[c]), ratio = transmitted * reflected;
      const FloatLanes through = entering * entering * transmitted, bounced = through * ratio;
      return Vec3Lanes{through, bounced, bounced * ratio / max(one - ratio, FloatLanes(kTiny))};
    };
    const Vec3Lanes red = channel(0), green = channel(1), blue = channel(2);
    energies_[0] = {red.x, green.x, blue.x};
    energies_[1] = {red.y, green.y, blue.y};
    energies_[2] = {red.z, green.z, blue.z};

    // Sample lobes by their luminance.
    const Vec3Lanes luminance = 0.212671f * red + 0.715160f * green + 0.072169f * blue;
    const FloatLanes each = one / (reflected + luminance.x + luminance.y + luminance.z);
    shares_ = {reflected * each, luminance.x * each, luminance.y * each, luminance.z * each};

    // Find the perfect azimuths, up to full turns.
    const FloatLanes gamma_o = asin(h), gamma_t = asin(sin_gamma);
    perfect_[0] = -2.0f * gamma_o;
    perfect_[1] = 2.0f * (gamma_t - gamma_o) + kPi;
    perfect_[2] = 4.0f * gamma_t - 2.0f * gamma_o;
  }

  /// M_p N_p of each lobe.
  Densities densities(const Vec3Lanes& towards) const {
    const FibreFrame::Angles i = frame_.angles(towards);
    Densities each;
    for (int p = 0; p < HairMaterial::kLobes; ++p) {
      const FloatLanes along = longitudinal_density(material_.lobes[p], i.sine, i.cosine, sin_o_[p], cos_o_[p]);
      each[p] = along * (p < kDirected ? azimuthal_density(material_, i.phi - perfect_[p]) : FloatLanes(0.5f / kPi));
    }
    return each;
  }

  Vec3Lanes value(const Densities& each) const {
    const FloatLanes white = reflected_ * each[0];
    Vec3Lanes sum = {white, white, white};
    for (int p = 1; p < HairMaterial::kLobes; ++p) sum = sum + each[p] * energies_[p - 1];
    return sum;
  }

  FloatLanes density(const Densities& each) const {
    FloatLanes sum = shares_[0] * each[0];
    for (int p = 1; p < HairMaterial::kLobes; ++p) sum += shares_[p] * each[p];
    return sum;
  }

  const HairMaterial& material_;
  FibreFrame frame_;
  FloatLanes sin_o_[HairMaterial::kLobes], cos_o_[HairMaterial::kLobes];  ///< as the scales turn it for each lobe
  FloatLanes perfect_[kDirected];
  FloatLanes reflected_;
  Vec3Lanes energies_[HairMaterial::kLobes - 1];  ///< of TT, TRT and the rest
  std::array<FloatLanes, HairMaterial::kLobes> shares_;
};

}  // namespace fastlines
