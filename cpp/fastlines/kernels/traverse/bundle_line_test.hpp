// A cheap conservative test of 16 rays of a bundle against a segment's line: a few multiplications per packet.
#pragma once

#include "../../layout/wide_bvh.hpp"
#include "../intersect/load_fields.hpp"
#include "../rays/ray_views.hpp"
#include "ray_bundle.hpp"

namespace fastlines {

struct BundleLineTestTuning {
  /// Packets that stay in registers while all lines are tested against them. With an apex, a packet needs three vectors
  /// (dx, dy, max_depth) instead of six.
  template <bool from_apex>
  static constexpr int kMaxPackets = from_apex && FloatX16::kRegisters == 1 ? 4 : 2;
};

/// A packet of a bundle in the bundle's coordinates: a copy if 16 floats fit into one or two registers. For the
/// compiler, stores between two lines may alias the bundle, and loading it again would take as long as the test.
struct BundleRays {
  using Scalar = std::conditional_t<(FloatX16::kRegisters <= 2), FloatX16, PacketView::Scalar>;
  Scalar x, y, dx, dy, moment, max_depth;

  [[gnu::always_inline]] BundleRays(const RayBundle& bundle, int first)
      : x(PacketView::Scalar{bundle.x + first}),
        y(PacketView::Scalar{bundle.y + first}),
        dx(PacketView::Scalar{bundle.dx + first}),
        dy(PacketView::Scalar{bundle.dy + first}),
        moment(PacketView::Scalar{bundle.moment + first}),
        max_depth(PacketView::Scalar{bundle.max_depth + first}) {}
};

/// 16 segments, and their lines in the bundle's coordinates. For the ray (x, y) + z·(x', y') and the line p + s·e,
///
///     m = (p_y·e_x − p_x·e_y) + x'·(p_z·e_y − p_y·e_z) + y'·(p_x·e_z − p_z·e_x) + x·e_y − y·e_x − (x·y' − y·x')·e_z
///
/// is their distance times |(x', y', 1) × e|, which is at most |c × e| + |(x', y')|·|e|.
template <AxisPrimitive P>
struct BundleLineTest {
  alignas(64) float fields[P::kFields][kSimdWidth];  // what the exact test reads, in the frame
  /// The coefficients of m in x, y, x', y' and the moment of a ray, and its constant term.
  alignas(64) float m_x[kSimdWidth], m_y[kSimdWidth], m_dx[kSimdWidth], m_dy[kSimdWidth], m_moment[kSimdWidth],
      m_constant[kSimdWidth];
  /// For a hit, |m| ≤ max_moment and min_depth ≤ the ray's max_depth.
  alignas(64) float max_moment[kSimdWidth], min_depth[kSimdWidth];

  /// Load 16 segments. All 16 ids must be valid, even if fewer are tested.
  void load(const WideBvhView<P>& tree, const std::uint32_t* prims, const RayBundle& bundle) {
    using F = FloatX16;
    const Fields<P, F> segments = load_fields(tree, [&](int j) { return prims[j]; });
    for (int k = 0; k < P::kFields; ++k) segments[k].store(fields[k]);
    // Transform the segments into the basis of the bundle.
    const F from[3] = {segments[0] - F(bundle.centre[0]), segments[1] - F(bundle.centre[1]),
                       segments[2] - F(bundle.centre[2])};
    const F to[3] = {segments[3], segments[4], segments[5]};
    const auto dot = [](const F(&w)[3], const auto& b) {
      return fma(w[2], F(b[2]), fma(w[1], F(b[1]), w[0] * F(b[0])));
    };
    const F px = dot(from, bundle.u), py = dot(from, bundle.v), pz = dot(from, bundle.c);
    const F ex = dot(to, bundle.u), ey = dot(to, bundle.v), ez = dot(to, bundle.c), zero = 0.0f;
    // Store the coefficients of m.
    ey.store(m_x);
    (zero - ex).store(m_y);
    (pz * ey - py * ez).store(m_dx);
    (px * ez - pz * ex).store(m_dy);
    (zero - ez).store(m_moment);
    (py * ex - px * ey).store(m_constant);
    // Bound the moment and the depth. Lengths count as at least 1e-18: the squares of shorter ones underflow, but m
    // does not.
    const F e_perp2 = fma(ex, ex, fma(ey, ey, F(1e-36f))), length = sqrt(fma(ez, ez, e_perp2));
    F cull_radius = 1.0001f * bundle.cull_radius, depth = bundle.depth;
    if constexpr (kHasRadius<P>) {
      cull_radius = cull_radius + F(1.0001f) * P::frame_radius(segments);
      depth = depth - P::frame_radius(segments);
    }
    fma(fma(F(bundle.slope), length, sqrt(e_perp2)), cull_radius, F(bundle.resolution) * length).store(max_moment);
    (pz + depth + min(ez, zero)).store(min_depth);
  }

  /// Call visit(j, first, near) for each of the first n segments and each packet, which begins at lane `first`. `near`
  /// is a mask of the rays that may hit segment j, and may be 0. For one packet, j ascends.
  template <class Visit>
  [[gnu::always_inline]] void test(const RayBundle& bundle, int n, Visit&& visit) const {
    if (bundle.from_apex)
      test_with<true>(bundle, n, visit);
    else
      test_with<false>(bundle, n, visit);
  }

 private:
  template <bool from_apex, class Visit>
  [[gnu::always_inline]] void test_with(const RayBundle& bundle, int n, Visit& visit) const {
    constexpr int max_packets = BundleLineTestTuning::kMaxPackets<from_apex>;
    int first = bundle.first;
    const auto test_packets = [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
      const BundleRays rays[] = {BundleRays(bundle, first + int(i) * kSimdWidth)...};
      for (int j = 0; j < n; ++j) {
        const std::uint32_t masks[] = {near_mask<from_apex>(j, rays[i])...};
        (visit(j, first + int(i) * kSimdWidth, masks[i]), ...);
      }
      first += int(sizeof...(i)) * kSimdWidth;
    };
    while (bundle.end - first >= max_packets * kSimdWidth) test_packets(std::make_index_sequence<max_packets>());
    while (bundle.end - first > 0) test_packets(std::make_index_sequence<1>());
  }

  /// A mask of the rays that may hit segment j. With an apex, x, y and moment are 0.
  template <bool from_apex>
  [[gnu::always_inline]] std::uint32_t near_mask(int j, const BundleRays& rays) const {
    using F = FloatX16;
    F m = fma(rays.dy, F(m_dy[j]), fma(rays.dx, F(m_dx[j]), F(m_constant[j])));
    if constexpr (!from_apex) m = fma(rays.moment, F(m_moment[j]), fma(rays.y, F(m_y[j]), fma(rays.x, F(m_x[j]), m)));
    return ((abs(m) <= F(max_moment[j])) & (F(min_depth[j]) <= rays.max_depth)).bits();
  }
};

}  // namespace fastlines
