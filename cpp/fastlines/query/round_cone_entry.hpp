// Where lines enter round cones that they hit, in float64: one line and one round cone, or eight of either.
//
// The formulas are those of primitives/round_cone_test.hpp, in the coordinates of the scene. Q is expanded around a
// point of the axis as there.
#pragma once

#include <limits>

#include "../simd/double_x1.hpp"

namespace fastlines {

/// A round cone: the start and the edge of its axis, its radius at the start, and how much larger it is at the end.
template <class N>
struct RoundConeInDouble {
  Vector3<N> start, edge;
  N radius, slope;
};

/// Where a line enters: t in units of the direction's length, and s of the ball that the line touches there. t is NaN
/// if rounding makes the line miss.
template <class N>
struct EntryInDouble {
  N t, s;
};

template <class N>
EntryInDouble<N> enter(const RoundConeInDouble<N>& cone, const Vector3<N>& origin, const Vector3<N>& direction) {
  using Mask = MaskOf<N>;
  const N zero = 0.0, one = 1.0, &slope = cone.slope;
  const N length = sqrt(dot(direction, direction));
  const Vector3<N> ray = direction / length;
  // Measure depths from the point of the line that is nearest to the middle of the axis, so that nothing cancels.
  const N shift = dot(cone.start + N(0.5) * cone.edge - origin, ray);
  const Vector3<N> offset = cone.start - origin - shift * ray;
  const N p_r = dot(offset, ray), e_r = dot(cone.edge, ray);
  const Vector3<N> a = offset - p_r * ray, b = cone.edge - e_r * ray;
  const N b2 = dot(b, b), m2 = slope * slope, c2 = m2 - b2, length2 = e_r * e_r - c2;
  const Mask is_steep = zero <= c2, grows = zero < slope;
  const N larger_end = blend(grows, one, zero);

  // The centre of the ball at s across the ray, its radius, Q(s), and half the derivative of Q there.
  struct Ball {
    Vector3<N> x;
    N reach, c0, c1;
  };
  const auto ball_at = [&](const N& s) {
    const Vector3<N> x = a + s * b;
    const N reach = cone.radius + s * slope;
    return Ball{x, reach, reach * reach - dot(x, x), reach * slope - dot(x, b)};
  };

  // The line hits if the largest Q, the squared half chord in the ball at s, is 0 or more.
  N from = blend(is_steep, larger_end, clamp_to_1((dot(a, b) - cone.radius * slope) / c2));
  Ball ball = ball_at(from);
  N discriminant = ball.c1 * ball.c1 - ball.c0 * c2;
  const Mask hits = zero <= ball.c0;
  // Expand Q where the radius is least, and find the ball that the line touches.
  const Mask tapers = b2 < N(2.0) * m2;
  if (any(tapers)) {
    from = blend(tapers, one - larger_end, from);
    ball = ball_at(from);
    const Vector3<N> g = slope * ball.x - ball.reach * b;
    const N across = dot(cross(ball.x, b), ray);
    discriminant = blend(is_steep, dot(g, g) - across * across, discriminant);
  }
  const N w = e_r * sqrt(at_least(0.0, discriminant) / length2);
  const Mask cancels = zero < w * ball.c1;
  const N step = blend(cancels, ball.c1 * ball.c1 - e_r * e_r * ball.c0, w - ball.c1) /
                 blend(cancels, length2 * (w + ball.c1), c2);
  const N touched = from + step;
  const N end = blend(Mask(slope == zero), blend(Mask(e_r < zero), one, zero), larger_end);
  const Mask at_end = is_steep & ((e_r * slope <= zero) | (length2 <= zero));
  const N s = blend(at_end, end, clamp_to_1(blend(Mask(touched == touched), touched, zero)));
  const N depth = p_r + s * e_r - sqrt(at_least(0.0, ball_at(s).c0));
  return {(blend(hits, depth, N(std::numeric_limits<double>::quiet_NaN())) + shift) / length, s};
}

}  // namespace fastlines
