// Whether a ray surely misses the whole scene, before it is prepared: without a square root or a division.
//
// The box of the scene, relative to its centre, has half sides h, and is grown by G: the radius of the query and all
// rounding. With p = o − centre, the line p + t·d misses it if an axis separates them (Gottschalk et al. 1996,
// "OBBTree"):
//
//     |p_y·d_z − p_z·d_y| > (h_y + G)·|d_z| + (h_z + G)·|d_y|,      or the same with x, y and z rotated.
//
// The part in [t_min, t_max] misses it if both ends lie beyond the same face.
//
// Nothing is lost. In units of the scene, the exact test of the prepared ray finds hits up to ρ + 2⁻²⁰·(3/σ + |o'| + ρ)
// + overhang/σ from an axis (rays/ray.hpp), where |o'|·|d| = |p × d|. Here the sums of |p_i·d_j| and of |p_i| bound
// |o'|. They are multiplied by 2⁻¹⁶, which also covers all roundings here, each at most 2⁻²⁴ of a term.
#pragma once

#include <limits>

#include "../../layout/wide_bvh.hpp"
#include "../../rays/ray.hpp"

namespace fastlines {

/// The box of a scene, as rays are culled with it.
class SceneCull {
 public:
  template <RayPrimitive P>
  explicit SceneCull(const WideBvhView<P>& tree) : centre_(vector_of(tree.frame.centre)) {
    const Frame& frame = tree.frame;
    const float unit = 1.0f / frame.scale;
    // Infinity for an empty scene, which any ray then seems to reach.
    half_ = max(abs(vector_of(tree.box.lo)), abs(vector_of(tree.box.hi))) * (unit * (1.0f + kRelative));
    margin_ = (4.0f * kRelative + 2.0f * frame.overhang) * unit + kLeast;
  }

  /// Whether a valid ray without a spread surely hits nothing.
  [[gnu::always_inline]] bool surely_misses(const RayQuery& ray) const {
    const FloatX4 p = vector_of(ray.origin) - centre_, far = abs(p);
    const FloatX4 half = half_ + (ray.radius * (1.0f + kRelative) + margin_);
    // Most rays from within the scene go through its box.
    if (!any(far > half)) return false;
    const FloatX4 d = vector_of(ray.direction);
    return any(lies_across(p, d, half) | lies_beyond(p + ray.t_min * d, p + ray.t_max * d, half, kRelative * sum(far)));
  }

 private:
  /// The axes that are perpendicular to x, y or z, and separate the line p + t·d from the box with these half sides.
  [[gnu::always_inline]] static IntX4 lies_across(const FloatX4& p, const FloatX4& d, const FloatX4& half) {
    const FloatX4 one = yzx(p) * zxy(d), other = zxy(p) * yzx(d), along = abs(d);
    const float rounding = kRelative * sum(abs(one) + abs(other)) + kLeast;
    return abs(one - other) > yzx(half) * zxy(along) + zxy(half) * yzx(along) + rounding;
  }

  /// The faces of the box that both ends of a ray lie beyond. An end is NaN if the ray is perpendicular to an axis, and
  /// endless there: then the other end decides.
  [[gnu::always_inline]] static IntX4 lies_beyond(const FloatX4& start, const FloatX4& end, const FloatX4& half,
                                                  float rounding) {
    const FloatX4 face = (half + rounding) * (1.0f + kRelative);
    const IntX4 above = ((start > face) & ~(end <= face)) | ((end > face) & ~(start <= face));
    const IntX4 below = ((start < -face) & ~(end >= -face)) | ((end < -face) & ~(start >= -face));
    return above | below;
  }

  // Three lanes count; the fourth is 0.
  [[gnu::always_inline]] static FloatX4 vector_of(const Vec3& v) { return FloatX4{v[0], v[1], v[2], 0.0f}; }
  [[gnu::always_inline]] static FloatX4 abs(const FloatX4& x) { return FloatX4(IntX4(x) & 0x7fff'ffff); }
  [[gnu::always_inline]] static FloatX4 yzx(const FloatX4& x) { return __builtin_shufflevector(x, x, 1, 2, 0, 3); }
  [[gnu::always_inline]] static FloatX4 zxy(const FloatX4& x) { return __builtin_shufflevector(x, x, 2, 0, 1, 3); }
  [[gnu::always_inline]] static float sum(const FloatX4& x) { return x[0] + x[1] + x[2]; }
  [[gnu::always_inline]] static bool any(const IntX4& mask) { return (mask[0] | mask[1] | mask[2]) != 0; }

  static constexpr float kRelative = 0x1p-16f, kLeast = std::numeric_limits<float>::min();
  FloatX4 centre_, half_;
  float margin_;
};

}  // namespace fastlines
