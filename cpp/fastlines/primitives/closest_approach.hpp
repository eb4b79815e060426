// What an exact test returns.
#pragma once

#include "../simd/float_x1.hpp"

namespace fastlines {

/// The point at which t is taken: the closest approach, or where the ray enters the surface. With `entry`, only rays
/// that enter hit: those that start inside, or on the surface, do not.
enum class At { closest, surface, entry };

/// Whether hits have a t_out.
constexpr bool has_exit(At at) { return at != At::closest; }

/// The closest approach of a ray to a primitive, or its entry: t in the frame, and s of the nearest point of the axis.
/// Without an axis, s and dist2 are 0.
template <class N>
struct ClosestApproach {
  N s, t, dist2;
  MaskOf<N> hit;  ///< whether the ray comes within its radius
};

/// The point at which a class takes t, fixed at compile time. A derived class has the member `at`.
template <At at_>
struct FixedAt {
  static constexpr At at = at_;
  static constexpr bool kHasExit = has_exit(at_);
};
/// The same, chosen at run time, for classes whose code would otherwise be compiled several times.
struct ChosenAt {
  At at;
};
/// The same where t is on the surface: `At::surface` or `At::entry`, chosen at run time.
struct SurfaceAt {
  static constexpr bool kHasExit = true;
  struct Choice {
    bool is_entry;
    constexpr operator At() const { return is_entry ? At::entry : At::surface; }
  } at;

  SurfaceAt(At at_ = At::surface) : at{at_ == At::entry} {}
};

/// The approach of an exact test, with t at the point that `at` names. Every answer comes from here.
/// It is returned by value: a reference that escapes would keep the whole test and its rays in memory.
template <class Test>
[[gnu::always_inline]] inline auto approach_at(At at, const Test& test) {
  if (at == At::closest) return test.closest;
  auto in = test.entry();
  if (at == At::entry) in.hit = in.hit & test.enters(in);
  return in;
}

}  // namespace fastlines
