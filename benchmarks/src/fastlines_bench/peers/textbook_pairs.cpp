// All pairs of segments by the formula of textbooks, 16 at a time (peers/pairs.py compiles it).
//
// The nearest points of two segments are at s and t, where s is that of the lines, clamped to [0, 1], t is that of the
// point at s, clamped, and s is that of the point at t, clamped. Source: Ericson, "Real-Time Collision Detection",
// 2005, §5.1.9. In float32 the distance is inexact for nearly parallel lines, so it is compared with a radius that is
// larger by a thousandth, and pairs that remain are tested again in float64.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace {

constexpr int kLanes = 16;
typedef float Lanes __attribute__((vector_size(4 * kLanes)));
typedef std::int32_t Mask __attribute__((vector_size(4 * kLanes)));

template <class N>
N clamp01(N x) {
  const N zero = N{} + 0, one = zero + 1;
  x = x > zero ? x : zero;
  return x < one ? x : one;
}

/// The square of the distance of two segments, p + s·d and q + t·e. N is a number, or one for each lane.
template <class N>
N distance2(const N (&p)[3], const N (&d)[3], const N (&q)[3], const N (&e)[3]) {
  const auto dot = [](const N(&x)[3], const N(&y)[3]) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  const N r[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
  const N tiny = N{} + 1e-30f, dd = dot(d, d) + tiny, ee = dot(e, e) + tiny, de = dot(d, e), dr = dot(d, r),
          er = dot(e, r);
  const N s_lines = clamp01<N>((de * er - dr * ee) / (dd * ee - de * de + tiny));
  const N t = clamp01<N>((de * s_lines + er) / ee), s = clamp01<N>((de * t - dr) / dd);
  N sum = N{};
  for (int k = 0; k < 3; ++k) {
    const N x = r[k] + s * d[k] - t * e[k];
    sum += x * x;
  }
  return sum;
}

/// A segment in float64, from its start along its edge.
struct Segment {
  double p[3], d[3];

  explicit Segment(const float* ends) {
    for (int k = 0; k < 3; ++k) {
      p[k] = ends[k];
      d[k] = double(ends[3 + k]) - p[k];
    }
  }
};

bool any(const Mask& mask) {
  Mask joined = mask;
  std::int64_t words[kLanes / 2], all = 0;
  std::memcpy(words, &joined, sizeof words);
  for (const std::int64_t word : words) all |= word;
  return all != 0;
}

}  // namespace

extern "C" {

/// Writes the pairs i < j whose distance is at most the radius, up to `room` of them, and returns their number. Pairs
/// of a strand, if that is not negative, that are at most `skip` apart are left out.
__attribute__((visibility("default"))) std::size_t textbook_pairs(std::size_t n, const float* ends,
                                                                  const std::int64_t* strand, float radius,
                                                                  std::int64_t skip, std::size_t room,
                                                                  std::int64_t* pairs) {
  // Store the segments as columns of lanes. The last lanes are far from everything.
  const std::size_t n_blocks = (n + kLanes - 1) / kLanes;
  std::vector<Lanes> columns(6 * n_blocks);
  for (std::size_t i = 0; i < n_blocks * kLanes; ++i)
    for (int k = 0; k < 3; ++k) {
      const float p = i < n ? ends[6 * i + k] : 1e15f;
      columns[6 * (i / kLanes) + k][i % kLanes] = p;
      columns[6 * (i / kLanes) + 3 + k][i % kLanes] = i < n ? ends[6 * i + 3 + k] - p : 0;
    }

  const double radius2 = double(radius) * radius;
  const Lanes limit = Lanes{} + float(radius2 * 1.001 + 1e-30);
  std::size_t n_found = 0;
  for (std::size_t i = 0; i < n; ++i) {
    Lanes p[3], d[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = Lanes{} + columns[6 * (i / kLanes) + k][i % kLanes];
      d[k] = Lanes{} + columns[6 * (i / kLanes) + 3 + k][i % kLanes];
    }
    for (std::size_t block = i / kLanes; block < n_blocks; ++block) {
      const Lanes* const c = &columns[6 * block];
      const Lanes q[3] = {c[0], c[1], c[2]}, e[3] = {c[3], c[4], c[5]};
      const Mask near = distance2<Lanes>(p, d, q, e) <= limit;
      if (!any(near)) continue;
      // Test the pairs that remain again.
      for (std::size_t j = std::max(i + 1, block * kLanes); j < std::min(n, (block + 1) * kLanes); ++j) {
        if (!near[j % kLanes]) continue;
        if (strand[i] >= 0 && strand[i] == strand[j] && std::int64_t(j - i) <= skip) continue;
        const Segment a(ends + 6 * i), b(ends + 6 * j);
        if (!(distance2<double>(a.p, a.d, b.p, b.d) <= radius2)) continue;
        if (n_found < room) {
          pairs[2 * n_found] = std::int64_t(i);
          pairs[2 * n_found + 1] = std::int64_t(j);
        }
        ++n_found;
      }
    }
  }
  return n_found;
}
}
