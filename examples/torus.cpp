// A primitive of your own on the fast path, the torus: every kernel gives the answers of brute force, bit for bit.
//
//     g++ -std=c++20 -O2 -mavx2 -mfma -mbmi -mbmi2 -ffp-contract=off -pthread -I cpp examples/torus.cpp -o torus &&
//     ./torus
//
// Let p be the point of a ray's line that is nearest to the centre, as seen from there, and d the ray's unit direction.
// With R and r the radii of ring and tube, n the axis, k = |p|² + R² − r², a = p·n, b = d·n, the point p + s·d is in
// the torus where
//
//     q(s) = s⁴ + (2k − 4R²(1 − b²))·s² + 8R²ab·s + k² − 4R²(|p|² − a²) ≤ 0.
//
// The roots of q″ are known, and isolate those of q′; these isolate those of q. Bisection finds them, in float64.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

#include "fastlines/core.hpp"

using namespace fastlines;

namespace {

/// A solid torus.
struct Torus {
  Vec3 centre, axis;  ///< the axis is a unit vector
  float ring, tube;   ///< radii: of the ring, and of the tube around it
};

/// Where a ray enters a torus, and leaves it for the first time, within its bounds.
struct TorusHit {
  float t, t_out;
  bool hit;
};

/// Where a condition begins or ceases to hold; `high` if it does not change.
template <class Holds>
double bisect(const Holds& holds, double low, double high) {
  const bool at_low = holds(low);
  for (int i = 0; i < 52; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) == at_low ? low : high) = middle;
  }
  return high;
}

/// The exact test. x is a ray and the fields of a torus: origin, direction, t_min, t_max, radius; centre, axis, radii.
TorusHit meet_torus(const float (&x)[17]) {
  const auto dot = [](const auto* u, const auto* v) {
    return double(u[0]) * v[0] + double(u[1]) * v[1] + double(u[2]) * v[2];
  };
  const double length = std::sqrt(dot(&x[3], &x[3])), ring = x[15], tube = double(x[16]) + x[8];
  double p[3], d[3], n[3];
  for (int i = 0; i < 3; ++i) {
    d[i] = x[3 + i] / length;
    p[i] = double(x[i]) - x[9 + i];
    n[i] = x[12 + i];
  }
  const double nearest = -dot(p, d), outer = ring + tube;
  for (int i = 0; i < 3; ++i) p[i] += nearest * d[i];
  const double pp = dot(p, p), a = dot(p, n), b = dot(d, n), half = std::sqrt(std::max(outer * outer - pp, 0.0));
  const double low = std::max(x[6] * length - nearest, -half), high = std::min(x[7] * length - nearest, half);
  if (pp > outer * outer || low > high) return {0.0f, 0.0f, false};

  const double k = pp + ring * ring - tube * tube, four = 4.0 * ring * ring;
  const double c2 = 2.0 * k - four * (1.0 - b * b), c1 = 2.0 * four * a * b, c0 = k * k - four * (pp - a * a);
  const auto inside = [=](double s) { return ((s * s + c2) * s + c1) * s + c0 <= 0.0; };
  const auto rises = [=](double s) { return (4.0 * s * s + 2.0 * c2) * s + c1 > 0.0; };
  // Isolate the roots.
  const double bend = std::sqrt(std::max(-c2 / 6.0, 0.0));
  const double bends[4] = {low, std::clamp(-bend, low, high), std::clamp(bend, low, high), high};
  double ends[5] = {low, 0.0, 0.0, 0.0, high};
  for (int i = 0; i < 3; ++i) ends[i + 1] = bisect(rises, bends[i], bends[i + 1]);
  // Find the first place inside, and the next one outside.
  int enter = 0;
  while (enter < 5 && !inside(ends[enter])) ++enter;
  if (enter == 5) return {0.0f, 0.0f, false};
  int leave = enter + 1;
  while (leave < 5 && inside(ends[leave])) ++leave;
  const double s = enter == 0 ? low : bisect(inside, ends[enter - 1], ends[enter]);
  const double s_out = leave == 5 ? high : bisect(inside, ends[leave - 1], ends[leave]);
  const auto to_t = [&](double at) { return std::clamp(float((at + nearest) / length), x[6], x[7]); };
  return {to_t(s), to_t(s_out), true};
}

/// The same for 16 tori or rays, lane by lane.
inline ClosestApproach<float> meet_tori(const float (&x)[17], float& t_out) {
  const TorusHit found = meet_torus(x);
  t_out = found.t_out;
  return {0.0f, found.t, 0.0f, found.hit};
}
inline ClosestApproach<FloatX16> meet_tori(const FloatX16 (&x)[17], FloatX16& t_out) {
  alignas(64) float columns[17][kSimdWidth], t[kSimdWidth], out[kSimdWidth], hit[kSimdWidth];
  for (int k = 0; k < 17; ++k) x[k].store(columns[k]);
  for (int i = 0; i < kSimdWidth; ++i) {
    float lane[17];
    for (int k = 0; k < 17; ++k) lane[k] = columns[k][i];
    const TorusHit found = meet_torus(lane);
    t[i] = found.t;
    out[i] = found.t_out;
    hit[i] = found.hit ? 1.0f : 0.0f;
  }
  t_out = FloatX16::load(out);
  const FloatX16 zero = 0.0f;
  return {zero, FloatX16::load(t), zero, zero < FloatX16::load(hit)};
}

/// The test of one ray and one torus, or of 16 of either.
template <class N>
struct TorusTest {
  N t_min, t_out;
  ClosestApproach<N> closest;

  template <class R, class V>
  TorusTest(const R& ray, const V& fields) : t_min(ray.t_min) {
    N x[17];
    for (int k = 0; k < 3; ++k) {
      x[k] = ray.o[k];
      x[3 + k] = ray.r[k];
    }
    x[6] = t_min;
    x[7] = ray.t_max;
    x[8] = fastlines::sqrt(N(ray.radius2));
    for (int k = 0; k < 8; ++k) x[9 + k] = fields[k];
    closest = meet_tori(x, t_out);
  }

  ClosestApproach<N> entry() const { return closest; }
  N exit() const { return t_out; }
  fastlines::MaskOf<N> enters(const ClosestApproach<N>& entry) const { return t_min < entry.t; }
};

/// Tori as a set of primitives, for builders and for the fast path.
struct Tori {
  using Item = Torus;
  static constexpr const char* kKind = "tori";
  static constexpr int kFields = 8;  // centre, axis, radii

  std::span<const Torus> data;

  std::size_t size() const { return data.size(); }
  const Torus* items() const { return data.data(); }
  const Torus& item(std::uint32_t prim) const { return data[prim]; }

  Box bounds(std::uint32_t prim) const {
    const auto& [centre, axis, ring, tube] = data[prim];
    Vec3 half;
    for (int k = 0; k < 3; ++k) half[k] = ring * std::sqrt(std::max(0.0f, 1.0f - axis[k] * axis[k])) + tube;
    return {centre - half, centre + half};
  }
  /// Conservative: the box of the whole, in the other box.
  Box clipped_bounds(std::uint32_t prim, const Box& box) const { return intersection(bounds(prim), box); }

  /// A torus in the frame of the scene.
  template <class N, class Frame>
  static std::array<N, kFields> fields(const N (&floats)[kFields], const Frame& frame) {
    std::array<N, kFields> fields;
    for (int k = 0; k < 3; ++k) {
      fields[k] = (floats[k] - N(frame.centre[k])) * N(frame.scale);
      fields[3 + k] = floats[3 + k];
    }
    for (int k = 6; k < 8; ++k) fields[k] = floats[k] * N(frame.scale);
    return fields;
  }
  template <class N, class R, class V>
  static TorusTest<N> test(const R& ray, const V& fields) {
    return {ray, fields};
  }
};
static_assert(RayPrimitive<Tori>);

/// Tori in a cube.
std::vector<Torus> some_tori(int n) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) { return float(low + (high - low) * (random() / 4294967296.0)); };
  std::vector<Torus> tori;
  while (int(tori.size()) < n) {
    const Vec3 centre{uniform(-4, 4), uniform(-4, 4), uniform(-4, 4)},
        axis{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    const float length = std::sqrt(dot(axis, axis)), ring = uniform(0.2, 0.7);
    if (0.1f < length && length < 1.0f)
      tori.push_back({centre, axis * (1.0f / length), ring, ring * uniform(0.1, 0.4)});
  }
  return tori;
}

/// The first hits of a batch.
struct Found {
  std::vector<float> t, u, distance, t_out;
  std::vector<std::int64_t> prim;

  explicit Found(std::size_t n) : t(n), u(n), distance(n), t_out(n), prim(n) {}
  HitColumns columns() { return {t.data(), prim.data(), u.data(), distance.data(), t_out.data()}; }
  bool operator==(const Found&) const = default;  // no number is NaN, or 0 of either sign
};

}  // namespace

int main() {
  const std::vector<Torus> data = some_tori(1000);
  const Tori tori{data};
  Progress progress;
  Settings settings;
  settings.limits.max_leaf_refs = 16;
  const Tree tree = Builder(tori, settings, progress).build();
  const WideBvh wide = collapse(tree.nodes, tree.refs, tori, {}, /*n_threads=*/1, progress);
  const WideBvhView<Tori> view = view_of(wide, tori);

  // A picture of 128 × 128 rays.
  constexpr int side = 128;
  std::vector<Vec3> origins(side * side, Vec3{0, 0, 12}), directions;
  for (int i = 0; i < side * side; ++i)
    directions.push_back({float(i % side) / side - 0.5f, 0.5f - float(i / side) / side, -1.0f});
  const float radius = 0.01f, t_min = 0.0f, t_max = kInfinity;
  const RayBatch rays{origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}};

  Found expected(rays.size());
  const BruteForce<Tori> brute{tori, view.frame};
  first_hits(brute, rays, At::surface, 1, progress,
             [&](std::size_t i, const Hit& hit) { expected.columns().set(i, hit); });
  const auto n_hits = std::ranges::count_if(expected.prim, [](std::int64_t prim) { return prim >= 0; });

  int n_equal = 0;
  for (const Kernel kernel : {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle}) {
    Found found(rays.size());
    run_batch(view, rays, kernel, FirstHitQuery<Tori, SurfaceAt>{view, found.columns()}, 1, progress);
    n_equal += found == expected;
  }
  std::printf("%d of %d rays hit one of %d tori, and %d kernels agree with brute force\n", int(n_hits), side * side,
              int(data.size()), n_equal);
  return n_equal == 4 && n_hits > 0 ? 0 : 1;
}
