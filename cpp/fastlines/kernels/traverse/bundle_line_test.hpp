// Lines of segments beside the rays of a bundle: a test from afar, a few multiplications for sixteen rays.
#pragma once

#include "../../layout/wide_bvh.hpp"
#include "../intersect/exact_test.hpp"
#include "../rays/ray_views.hpp"
#include "ray_bundle.hpp"

namespace fastlines {

/// Sixteen rays of a bundle beside its axis, copied where sixteen floats are one or two registers: what is written from
/// line to line could be the bundle's as far as the compiler knows, and to read it again would load as long as the
/// test.
struct BundleRays {
  using Number = std::conditional_t<(FloatX16::kRegisters <= 2), FloatX16, PacketView::Number>;
  Number x, y, dx, dy, moment, last;

  [[gnu::always_inline]] BundleRays(const RayBundle& bundle, int first)
      : x(PacketView::Number{bundle.x + first}),
        y(PacketView::Number{bundle.y + first}),
        dx(PacketView::Number{bundle.dx + first}),
        dy(PacketView::Number{bundle.dy + first}),
        moment(PacketView::Number{bundle.moment + first}),
        last(PacketView::Number{bundle.last + first}) {}
};

/// Sixteen segments, in the frame, and their lines as a bundle sees them. For the ray (x, y) + z·(x', y') and the line
/// p + s·e,
///
///     m = (p_y·e_x − p_x·e_y) + x'·(p_z·e_y − p_y·e_z) + y'·(p_x·e_z − p_z·e_x) + x·e_y − y·e_x − (x·y' − y·x')·e_z
///
/// is their distance times |(x', y', 1) × e|, which is at max_moment |c × e| + |(x', y')|·|e|.
template <RayPrimitive P>
struct BundleLineTest {
  alignas(64) float lanes[P::kLanes][kSimdWidth];  // what the exact test reads
  alignas(64) float at_x[kSimdWidth], at_y[kSimdWidth], at_dx[kSimdWidth], at_dy[kSimdWidth], at_moment[kSimdWidth],
      constant[kSimdWidth];
  // Of a hit |m| is no more than `max_moment`, and the ray's `last` no less than `min_depth`.
  alignas(64) float max_moment[kSimdWidth], min_depth[kSimdWidth];

  /// Take sixteen segments, all of which have to be there, though fewer may be looked at.
  void load(const WideBvhView<P>& tree, const std::uint32_t* prims, const RayBundle& bundle) {
    using F = FloatX16;
    const Lanes<P, F> all = load_lanes(tree, [&](int j) { return prims[j]; });
    for (int k = 0; k < P::kLanes; ++k) all[k].store(lanes[k]);
    const F from[3] = {all[0] - F(bundle.centre[0]), all[1] - F(bundle.centre[1]), all[2] - F(bundle.centre[2])};
    const F to[3] = {all[3], all[4], all[5]};
    const auto dot = [](const F(&w)[3], const auto& b) {
      return fma(w[2], F(b[2]), fma(w[1], F(b[1]), w[0] * F(b[0])));
    };
    const F px = dot(from, bundle.u), py = dot(from, bundle.v), pz = dot(from, bundle.c);
    const F ex = dot(to, bundle.u), ey = dot(to, bundle.v), ez = dot(to, bundle.c), zero = 0.0f;
    ey.store(at_x);
    (zero - ex).store(at_y);
    (pz * ey - py * ez).store(at_dx);
    (px * ez - pz * ex).store(at_dy);
    (zero - ez).store(at_moment);
    (py * ex - px * ey).store(constant);
    // A length is never taken for less than 1e-18: squares of less are lost, but m is not.
    const F across2 = fma(ex, ex, fma(ey, ey, F(1e-36f))), length = sqrt(fma(ez, ez, across2));
    F reach = 1.0001f * bundle.reach, depth = bundle.depth;
    if constexpr (P::kHasRadius) {
      reach = reach + F(1.0001f) * P::lane_radius(all);
      depth = depth - P::lane_radius(all);
    }
    fma(fma(F(bundle.slope), length, sqrt(across2)), reach, F(bundle.resolution) * length).store(max_moment);
    (pz + depth + min(ez, zero)).store(min_depth);
  }

  /// Call visit(j, first, near) for each of the first n segments and each sixteen rays from `first` on: near has a bit
  /// for each that may come near the segment, or none. For the same rays, j rises.
  template <class Visit>
  [[gnu::always_inline]] void test(const RayBundle& bundle, int n, Visit&& visit) const {
    if (bundle.from_apex)
      test_as<true>(bundle, n, visit);
    else
      test_as<false>(bundle, n, visit);
  }

 private:
  template <bool from_apex, class Visit>
  [[gnu::always_inline]] void test_as(const RayBundle& bundle, int n, Visit& visit) const {
    constexpr int max_at_once = from_apex && FloatX16::kRegisters == 1 ? 4 : 2;
    int first = bundle.first;
    const auto some = [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
      const BundleRays rays[] = {BundleRays(bundle, first + int(i) * kSimdWidth)...};
      for (int j = 0; j < n; ++j) {
        const std::uint32_t bits[] = {near<from_apex>(j, rays[i])...};
        (visit(j, first + int(i) * kSimdWidth, bits[i]), ...);
      }
      first += int(sizeof...(i)) * kSimdWidth;
    };
    while (bundle.end - first >= max_at_once * kSimdWidth) some(std::make_index_sequence<max_at_once>());
    while (bundle.end - first > 0) some(std::make_index_sequence<1>());
  }

  /// Which of these rays may come near segment j. Where they come from one point, x, y and moment are nothing.
  template <bool from_apex>
  [[gnu::always_inline]] std::uint32_t near(int j, const BundleRays& rays) const {
    using F = FloatX16;
    F m = fma(rays.dy, F(at_dy[j]), fma(rays.dx, F(at_dx[j]), F(constant[j])));
    if constexpr (!from_apex)
      m = fma(rays.moment, F(at_moment[j]), fma(rays.y, F(at_y[j]), fma(rays.x, F(at_x[j]), m)));
    return ((abs(m) <= F(max_moment[j])) & (F(min_depth[j]) <= rays.last)).bits();
  }
};

}  // namespace fastlines
