// The exact test: does a ray come within its radius of a segment, and where? This one function defines every answer,
// brute force included; it is compiled without contraction, so its bits are the same everywhere.
//
// With p = P − o and e = Q − P in the ray's basis (u, v, r), the distance of the ray's point at t from P + s·e is
//
//     dist²(s, t) = (p_u + s·e_u)² + (p_v + s·e_v)² + (p_r + s·e_r − t)².
//
// It is convex. For the whole line t = p_r + s·e_r, and s = −(p_u·e_u + p_v·e_v)/(e_u² + e_v²), clamped to [0, 1]. If
// that t is outside [t_min, t_max], the best t is the bound, and s is the point of the segment nearest to the ray's
// point there. Where e_u² + e_v² is rounding noise the segment is parallel to the ray, or a point: of the equally near
// points the one with the smallest t counts.
#pragma once

#include "ray.hpp"

namespace fastlines {

/// Where t is taken: at the closest approach, or where the ray enters the capsule of its radius around the segment.
enum class At { closest, surface };

struct Approach {
  float s, t, dist2;  // t in the frame
  bool hit;
};

/// A segment in the basis of a ray.
struct Seen {
  float pu, pv, pr, eu, ev, er;
  float ee;       // |e|² across the ray
  bool parallel;  // ee is no more than noise
};

inline Seen see(const Ray& ray, const Segment& segment, const Frame& frame) {
  const Vec3 start = frame(segment.p);
  const Vec3 p = start - ray.o, e = frame(segment.q) - start;
  Seen seen{dot(p, ray.u), dot(p, ray.v), dot(p, ray.r), dot(e, ray.u), dot(e, ray.v), dot(e, ray.r), 0.0f, false};
  seen.ee = seen.eu * seen.eu + seen.ev * seen.ev;
  const float size = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) +
                     std::max({std::abs(e[0]), std::abs(e[1]), std::abs(e[2])});
  const float noise = std::ldexp(size, -22);
  seen.parallel = seen.ee <= noise * noise;
  return seen;
}

inline float clamp01(float s) { return std::min(std::max(s, 0.0f), 1.0f); }

inline Approach closest_approach(const Ray& ray, const Seen& g) {
  float s = g.parallel ? (g.er < 0.0f ? 1.0f : 0.0f) : clamp01(-(g.pu * g.eu + g.pv * g.ev) / g.ee);
  float t = g.pr + s * g.er;
  float along = 0.0f;
  if (t < ray.t_min || t > ray.t_max) {
    t = t < ray.t_min ? ray.t_min : ray.t_max;
    const float length2 = g.ee + g.er * g.er;
    s = length2 > 0.0f ? clamp01(-(g.pu * g.eu + g.pv * g.ev + (g.pr - t) * g.er) / length2) : 0.0f;
    along = g.pr - t + s * g.er;
  }
  const float x = g.pu + s * g.eu, y = g.pv + s * g.ev;
  const float dist2 = x * x + y * y + along * along;
  return {s, t, dist2, dist2 <= ray.radius2};
}

/// Where the line enters (sign −1) or leaves (sign +1) the capsule, and the s there; only after a hit.
inline std::pair<float, float> capsule_end(const Ray& ray, const Seen& g, float sign) {
  const auto half_chord = [&](float dist2) { return std::sqrt(std::max(ray.radius2 - dist2, 0.0f)); };
  float end;
  if (g.parallel) {
    end = (g.er < 0.0f) == (sign < 0.0f) ? 1.0f : 0.0f;
  } else {
    // On the cylinder around the whole line, if the point there belongs to the segment.
    const float length2 = g.ee + g.er * g.er;
    const float s_line = -(g.pu * g.eu + g.pv * g.ev) / g.ee;
    const float x = g.pu + s_line * g.eu, y = g.pv + s_line * g.ev;
    const float t = g.pr + s_line * g.er + sign * half_chord(x * x + y * y) * std::sqrt(length2 / g.ee);
    const float s = -(g.pu * g.eu + g.pv * g.ev + (g.pr - t) * g.er) / length2;
    if (s >= 0.0f && s <= 1.0f) return {t, s};
    end = s < 0.0f ? 0.0f : 1.0f;
  }
  // On the ball around an end.
  const float x = g.pu + end * g.eu, y = g.pv + end * g.ev;
  return {g.pr + end * g.er + sign * half_chord(x * x + y * y), end};
}

}  // namespace fastlines
