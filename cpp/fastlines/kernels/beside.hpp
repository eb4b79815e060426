// Lines of segments beside the rays of a bundle: a test from afar, a few multiplications for sixteen rays.
#pragma once

#include "../layout/wide.hpp"
#include "bundle.hpp"
#include "sixteen.hpp"

namespace fastlines {

/// Sixteen rays of a bundle beside its axis, copied where sixteen floats are one or two registers: what is written from
/// line to line could be the bundle's as far as the compiler knows, and to read it again would take as long as the
/// test.
struct RaysBeside {
  using Number = std::conditional_t<(Float16::kRegisters <= 2), Float16, Rays16::Number>;
  Number x, y, dx, dy, moment, last;

  [[gnu::always_inline]] RaysBeside(const Bundle& bundle, int first)
      : x(Rays16::Number{bundle.x + first}),
        y(Rays16::Number{bundle.y + first}),
        dx(Rays16::Number{bundle.dx + first}),
        dy(Rays16::Number{bundle.dy + first}),
        moment(Rays16::Number{bundle.moment + first}),
        last(Rays16::Number{bundle.last + first}) {}
};

/// Sixteen segments, in the frame, and their lines as a bundle sees them. For the ray (x, y) + z·(x', y') and the line
/// p + s·e,
///
///     m = (p_y·e_x − p_x·e_y) + x'·(p_z·e_y − p_y·e_z) + y'·(p_x·e_z − p_z·e_x) + x·e_y − y·e_x − (x·y' − y·x')·e_z
///
/// is their distance times |(x', y', 1) × e|, which is at most |c × e| + |(x', y')|·|e|.
struct LinesBeside {
  alignas(64) float start[3][kWidth], along[3][kWidth];
  alignas(64) float at_x[kWidth], at_y[kWidth], at_dx[kWidth], at_dy[kWidth], at_moment[kWidth], rest[kWidth];
  // Of a hit |m| is no more than `most`, and the ray's `last` no less than `nearest`.
  alignas(64) float most[kWidth], nearest[kWidth];

  /// Take sixteen segments, all of which have to be there, though fewer may be looked at.
  void take(const WideView& tree, const std::uint32_t* prims, const Bundle& bundle) {
    using F = Float16;
    F from[3], to[3];
    take_sixteen(tree, [&](int j) { return prims[j]; }, from, to);
    for (int k = 0; k < 3; ++k) {
      from[k].store(start[k]);
      to[k].store(along[k]);
      from[k] = from[k] - F(bundle.centre[k]);
    }
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
    (py * ex - px * ey).store(rest);
    // A length is never taken for less than 1e-18: squares of less are lost, but m is not.
    const F across2 = fma(ex, ex, fma(ey, ey, F(1e-36f))), length = sqrt(fma(ez, ez, across2));
    fma(fma(F(bundle.slope), length, sqrt(across2)), F(1.0001f * bundle.reach), F(bundle.grain) * length).store(most);
    (pz + F(bundle.depth) + min(ez, zero)).store(nearest);
  }

  /// Call see(j, first, near) for each of the first n segments and each sixteen rays from `first` on: near has a bit
  /// for each that may come near the segment, or none. For the same rays, j rises.
  template <class See>
  [[gnu::always_inline]] void look(const Bundle& bundle, int n, See&& see) const {
    if (bundle.from_point)
      look_as<true>(bundle, n, see);
    else
      look_as<false>(bundle, n, see);
  }

 private:
  template <bool from_point, class See>
  [[gnu::always_inline]] void look_as(const Bundle& bundle, int n, See& see) const {
    constexpr int most_at_once = from_point && Float16::kRegisters == 1 ? 4 : 2;
    int first = bundle.first;
    const auto some = [&]<std::size_t... i>(std::index_sequence<i...>) __attribute__((always_inline)) {
      const RaysBeside rays[] = {RaysBeside(bundle, first + int(i) * kWidth)...};
      for (int j = 0; j < n; ++j) {
        const std::uint32_t bits[] = {near<from_point>(j, rays[i])...};
        (see(j, first + int(i) * kWidth, bits[i]), ...);
      }
      first += int(sizeof...(i)) * kWidth;
    };
    while (bundle.end - first >= most_at_once * kWidth) some(std::make_index_sequence<most_at_once>());
    while (bundle.end - first > 0) some(std::make_index_sequence<1>());
  }

  /// Which of these rays may come near segment j. Where they come from one point, x, y and moment are nothing.
  template <bool from_point>
  [[gnu::always_inline]] std::uint32_t near(int j, const RaysBeside& rays) const {
    using F = Float16;
    F m = fma(rays.dy, F(at_dy[j]), fma(rays.dx, F(at_dx[j]), F(rest[j])));
    if constexpr (!from_point)
      m = fma(rays.moment, F(at_moment[j]), fma(rays.y, F(at_y[j]), fma(rays.x, F(at_x[j]), m)));
    return ((abs(m) <= F(most[j])) & (F(nearest[j]) <= rays.last)).bits();
  }
};

}  // namespace fastlines
