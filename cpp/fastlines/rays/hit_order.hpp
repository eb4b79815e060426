// The order of a ray's hits, and which piece reports a hit.
#pragma once

namespace fastlines {

/// The order of a ray's hits: by t, and at the same t by id. Branchless.
template <class Prim>
[[gnu::always_inline]] inline bool precedes(float t, Prim prim, float t2, Prim prim2) {
  return (t < t2) | ((t == t2) & (prim < prim2));
}

/// Whether the piece [s0, s1) of a segment owns the hit at s. Pieces tile [0, ∞), so exactly one of them reports it.
template <class N>
[[gnu::always_inline]] inline auto owns(N s0, N s1, N s) {
  return (s0 <= s) & (s < s1);
}

}  // namespace fastlines
