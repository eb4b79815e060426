// What fuzzers expect. A difference ends the program, as a crash does, so that libFuzzer keeps the file.
#pragma once

#include <cstdio>
#include <cstdlib>

#include "fastlines/rays/ray.hpp"

namespace fastlines::fuzz {

inline void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "wrong answer: %s\n", what);
  std::abort();
}

/// The same for the answer to a ray, which is printed.
inline void expect(bool holds, const char* what, const RayQuery& ray) {
  if (holds) return;
  const auto &o = ray.origin, &d = ray.direction;
  std::fprintf(stderr, "ray from %a %a %a along %a %a %a, t %a to %a, radius %a\n", o[0], o[1], o[2], d[0], d[1], d[2],
               ray.t_min, ray.t_max, ray.radius);
  expect(holds, what);
}

/// Hits are equal bit for bit, but for the sign of zero.
template <class A, class B>
bool same_hit(const A& a, const B& b) {
  return a.t == b.t && a.prim == b.prim && a.u == b.u && a.distance == b.distance && a.t_out == b.t_out;
}
template <class A, class B>
bool same_hits(const A& a, const B& b) {
  bool equal = a.size() == b.size();
  for (std::size_t i = 0; equal && i < a.size(); ++i) equal = same_hit(a[i], b[i]);
  return equal;
}

}  // namespace fastlines::fuzz
