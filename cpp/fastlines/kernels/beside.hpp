// Lines of segments beside the rays of a bundle: a test from afar, a few multiplications for sixteen rays.
#pragma once

#include "../layout/wide.hpp"
#include "bundle.hpp"
#include "sixteen.hpp"

namespace fastlines {

/// Up to sixteen segments and their lines as a bundle sees them. For the ray (x, y) + z·(x', y') and the line p + s·e,
///
///     m = (p_y·e_x − p_x·e_y) + x'·(p_z·e_y − p_y·e_z) + y'·(p_x·e_z − p_z·e_x) + x·e_y − y·e_x − (x·y' − y·x')·e_z
///
/// is their distance times |(x', y', 1) × e|, which is at most |c × e| + |(x', y')|·|e|.
struct LinesBeside {
  Sixteen segments;
  alignas(64) float start[3][kWidth], along[3][kWidth];  // of the same, in the frame
  alignas(64) float at_x[kWidth], at_y[kWidth], at_dx[kWidth], at_dy[kWidth], at_moment[kWidth], rest[kWidth];
  // Of a hit |m| is no more than `most`, and the ray's `last` no less than `nearest`.
  alignas(64) float most[kWidth], nearest[kWidth];

  void take(const WideView& tree, const std::uint32_t* prims, int n, const Bundle& bundle) {
    for (int j = 0; j < n; ++j) segments.put(j, tree.segments[prims[j]]);
    using F = Float16;
    F from[3], to[3];
    segments.in(tree.frame, from, to);
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
    (pz + min(ez, zero)).store(nearest);
  }

  /// Which of the rays [first, first + 16) may come near segment j.
  [[gnu::always_inline]] std::uint32_t near(const Bundle& bundle, int first, int j) const {
    using F = Float16;
    const auto at = [first](const float (&x)[kLanes]) { return F::load(x + first); };
    F m = fma(at(bundle.x), F(at_x[j]), F(rest[j]));
    m = fma(at(bundle.y), F(at_y[j]), m);
    m = fma(at(bundle.dx), F(at_dx[j]), m);
    m = fma(at(bundle.dy), F(at_dy[j]), m);
    m = fma(at(bundle.moment), F(at_moment[j]), m);
    return ((abs(m) <= F(most[j])) & (F(nearest[j]) <= at(bundle.last))).bits();
  }
};

}  // namespace fastlines
