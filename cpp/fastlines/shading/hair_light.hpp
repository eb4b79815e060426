// Light that hairs thinner than a pixel send to the eye: the far field, and what other hairs let pass and scatter back.
// fastlines.rendering.looks.hair has the formulas.
#pragma once

#include "across.hpp"
#include "hair_table.hpp"

namespace fastlines {

/// Light that arrives at 16 points of hairs, from one direction each.
struct ArrivingLight {
  Vec3Lanes towards, color;  ///< the unit direction to the light, and its irradiance
  FloatLanes crossed, far;   ///< how many hairs it crosses on average, and of these the ones that are far away
};

/// The light that goes to the eye. Without sharp lobes, what a hair scatters once is spread evenly over the half space
/// before it and the one behind. `density` is the share of what the hairs around scatter back that arrives.
inline Vec3Lanes hair_light(const HairTable& hair, const Vec3Lanes& tangents, const Vec3Lanes& to_eye,
                            const ArrivingLight& light, bool is_sharp, float density) {
  const Across in(tangents, light.towards), out(tangents, to_eye);
  const FloatLanes cos_phi = clamp(dot(in.across, out.across), -1.0f, 1.0f);
  const Vec3Lanes forward = hair.forward(in.sine), back = hair.backward(in.sine);
  const FloatLanes even = in.cosine * (1.0f / (kPi * kPi));
  const FloatLanes before = (1.0f + cos_phi) * even, behind = (1.0f - cos_phi) * even;
  const Vec3Lanes once = is_sharp ? hair.evaluate(out.sine, in.sine, acos(cos_phi)) : before * back + behind * forward;
  const FloatLanes reaches = exp(-light.far);
  const auto channel = [&](const FloatLanes& f, const FloatLanes& b, const FloatLanes& single) {
    const FloatLanes passed = exp(light.crossed * (f - 1.0f)) * reaches;
    const FloatLanes sum = 1.0f + b * b - f * f, zero = 0.0f;
    const FloatLanes pile = 2.0f * b / (sum + sqrt(max(sum * sum - 4.0f * (b * b), zero)));
    return passed * (single + density * max(pile - b, zero) * before);
  };
  return light.color * Vec3Lanes{channel(forward.x, back.x, once.x), channel(forward.y, back.y, once.y),
                                 channel(forward.z, back.z, once.z)};
}

}  // namespace fastlines
