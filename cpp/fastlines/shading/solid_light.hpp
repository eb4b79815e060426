// Light that solid lines send to the eye: surfaces, and lines thinner than a pixel. fastlines.rendering.looks.solid has
// the formulas.
#pragma once

#include <span>

#include "across.hpp"
#include "lights.hpp"

namespace fastlines {

/// What lines are made of: how much they scatter evenly, and the exponent and the middle of their highlight in white
/// light and in the colour of the line.
struct SolidMaterial {
  float diffuse, exponent, white, colored;
};

/// 16 points of lines: unit normals of surfaces, or the unit axes of thin lines.
struct SolidPoints {
  Vec3Lanes axes, to_eye, base;
  bool is_thin;
};

/// The fraction of the light from a direction that a thin line scatters evenly around its axis, per steradian.
inline FloatLanes around_axis(const SolidPoints& points, const Vec3Lanes& towards) {
  const Across in(points.axes, towards), out(points.axes, points.to_eye);
  return (1.0f + dot(in.across, out.across)) * in.cosine * (1.0f / (kPi * kPi));
}

/// How much of the light from a distant source goes to the eye.
inline Vec3Lanes reflected(const SolidPoints& points, const SolidMaterial& material, const Vec3Lanes& towards) {
  const Vec3Lanes half = unit(towards + points.to_eye);
  const FloatLanes aligned = dot(points.axes, half), zero = 0.0f;
  FloatLanes even, shine;
  if (points.is_thin) {
    even = around_axis(points, towards);
    shine = pow(max(1.0f - aligned * aligned, zero), FloatLanes(0.5f * material.exponent)) * even;
  } else {
    const FloatLanes facing = dot(points.axes, towards);
    even = max(facing, zero) * (1.0f / kPi);
    shine = select(facing > zero, pow(max(aligned, zero), FloatLanes(material.exponent)), zero);
  }
  const FloatLanes white = material.white * shine;
  return (material.diffuse * even + material.colored * shine) * points.base + Vec3Lanes{white, white, white};
}

/// Light that reaches the eye if nothing hides it, and where it comes from.
struct UnhiddenLight {
  Vec3Lanes towards, light;
};

/// The light of one lamp for each point, chosen by what the lamps bring if nothing hides them: so the mean is that of
/// all lamps, and there is no noise where nothing is hidden.
inline UnhiddenLight one_lamp(const SolidPoints& points, const SolidMaterial& material,
                              std::span<const DistantLight> lamps, const FloatLanes& first, const FloatLanes& second,
                              const FloatLanes& choice) {
  const FloatLanes zero = 0.0f;
  UnhiddenLight chosen{{zero, zero, zero}, {zero, zero, zero}};
  FloatLanes total = zero, of_chosen = zero;
  const auto arrives = [&](const DistantLight& lamp, const Vec3Lanes& towards) {
    return Vec3Lanes::of(lamp.color) * reflected(points, material, towards);
  };
  const auto sum = [](const Vec3Lanes& light) { return light.x + light.y + light.z; };
  // Choose by reservoir sampling: each lamp replaces the one before with the share that it has of the sum so far.
  FloatLanes left = choice;
  for (const DistantLight& lamp : lamps) {
    const Vec3Lanes towards = lamp.sample(first, second), light = arrives(lamp, towards);
    const FloatLanes own = sum(light);
    total += own;
    const FloatLanes share = select(total > zero, own / total, zero);
    const IntLanes takes = left < share;
    left = select(takes, left / share, (left - share) / max(1.0f - share, FloatLanes(1e-9f)));
    chosen.towards = select(takes, towards, chosen.towards);
    chosen.light = select(takes, light, chosen.light);
    of_chosen = select(takes, own, of_chosen);
  }
  chosen.light = select(of_chosen > zero, total / of_chosen, zero) * chosen.light;
  return chosen;
}

/// The light of the sky from one direction for each point.
inline UnhiddenLight of_sky(const SolidPoints& points, const SkyLight& sky, const FloatLanes& first,
                            const FloatLanes& second) {
  if (points.is_thin) {
    const Vec3Lanes towards = sphere(first, second);
    return {towards, (around_axis(points, towards) * (4.0f * kPi)) * (points.base * sky.radiance(towards))};
  }
  const Vec3Lanes towards = hemisphere(points.axes, first, second);
  return {towards, points.base * sky.radiance(towards)};
}

}  // namespace fastlines
