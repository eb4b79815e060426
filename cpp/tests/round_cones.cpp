// Compares the exact test of round cones with the definition of a hit in float64, found by a search for the minimum and
// not by a formula: scales, offsets, near-parallel rays, radii from 0 to more than the scene, one ball inside the
// other; tips, and rays aimed at them; rays with and without a spread. Packets of unlike cones have the bits of each.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "check.hpp"
#include "fastlines/primitives/spread_cones.hpp"
#include "fastlines/rays/frame_of.hpp"
#include "fastlines/rays/spread_ray.hpp"
#include "fastlines/simd/transpose.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

using Point = std::array<double, 3>;

Point along(const Vec3& from, const Vec3& to, double s) {
  Point at;
  for (int k = 0; k < 3; ++k) at[k] = from[k] + s * (double(to[k]) - from[k]);
  return at;
}

/// A ray and a round cone, in units of the caller's ray.
struct Case {
  RayQuery query;
  RoundCone cone;

  double reach(double s) const {
    const double own = double(cone.radius0) + s * (double(cone.radius1) - cone.radius0);
    return own + query.radius + query.spread * depth_of(along(cone.axis.p, cone.axis.q, s));
  }
  /// The depth of a point along the ray, in lengths.
  double depth_of(const Point& point) const {
    double dp = 0;
    for (int k = 0; k < 3; ++k) dp += query.direction[k] * (point[k] - query.origin[k]);
    return dp / length_of(query.direction);
  }
  /// The t between the bounds at which the ray is nearest to a point, and the squared distance there.
  std::pair<double, double> nearest_t(const Point& point) const {
    double dd = 0, dp = 0;
    for (int k = 0; k < 3; ++k) {
      dd += double(query.direction[k]) * query.direction[k];
      dp += query.direction[k] * (point[k] - query.origin[k]);
    }
    const double t = std::clamp(dp / dd, double(query.t_min), double(query.t_max));
    return {t, dist2_at(point, t)};
  }
  double dist2_at(const Point& point, double t) const {
    double dist2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double x = query.origin[k] + t * query.direction[k] - point[k];
      dist2 += x * x;
    }
    return dist2;
  }
  /// D(s) − R(s).
  double clearance(double s) const {
    return std::sqrt(nearest_t(along(cone.axis.p, cone.axis.q, s)).second) - reach(s);
  }
  /// How far the point of the ray at t is from the surface: negative inside.
  double depth_at(double t) const {
    return minimum([&](double s) { return std::sqrt(dist2_at(along(cone.axis.p, cone.axis.q, s), t)) - reach(s); });
  }
  double least_clearance() const {
    return minimum([&](double s) { return clearance(s); });
  }

 private:
  /// The minimum of a convex function over [0, 1], by golden-section search.
  template <class F>
  static double minimum(F&& f) {
    constexpr double kGolden = 0.6180339887498949;
    double low = 0, high = 1, a = 1 - kGolden, b = kGolden, at_a = f(a), at_b = f(b);
    for (int i = 0; i < 80; ++i) {
      if (at_a < at_b) {
        high = std::exchange(b, a);
        at_b = at_a;
        at_a = f(a = high - kGolden * (high - low));
      } else {
        low = std::exchange(a, b);
        at_a = at_b;
        at_b = f(b = low + kGolden * (high - low));
      }
    }
    return std::min({f(0), f(1), at_a, at_b});
  }
};

/// The largest deviations, as a fraction of the size of the scene.
struct Worst {
  double decision = 0, entry = 0, exit = 0;
  std::size_t n_hits = 0;
};

/// Check one case. `size` is that of the scene: its coordinates and radii, relative to its centre.
void check_case(const Case& one, const Frame& frame, double size, Worst& worst) {
  const Ray ray = prepare(one.query, frame);
  const auto fields = fields_of<RoundCones>(one.cone, frame);
  const auto test = RoundCones::test<float>(ray, fields);
  const double clearance = one.least_clearance();
  if (test.closest.hit != (clearance <= 0)) worst.decision = std::max(worst.decision, std::abs(clearance) / size);
  if (!test.closest.hit) return;
  ++worst.n_hits;
  check(test.closest.s >= 0 && test.closest.s <= 1, "s is that of a point of the axis");
  // The entry lies on the surface, or at a bound inside.
  const double t_in = ray.t_ray(test.entry().t), t_out = ray.t_ray(test.exit());
  check(t_in >= one.query.t_min && t_out <= one.query.t_max, "entry and exit lie within the bounds");
  const auto off = [&](double t, bool at_bound) {
    const double depth = one.depth_at(t);
    return (at_bound ? std::max(depth, 0.0) : std::abs(depth)) / size;
  };
  worst.entry = std::max(worst.entry, off(t_in, t_in == one.query.t_min));
  worst.exit = std::max(worst.exit, off(t_out, t_out == one.query.t_max));
  // The ray does not leave where it should enter, nor enter where it should leave.
  const double step = 1e-7 * size / length_of(one.query.direction);
  const auto leaves = [&](double t) { return one.depth_at(t - step) < one.depth_at(t + step); };
  if (t_in > one.query.t_min && leaves(t_in)) worst.entry = std::max(worst.entry, -clearance / size);
  if (t_out < one.query.t_max && !leaves(t_out)) worst.exit = std::max(worst.exit, -clearance / size);
}

/// Compare the test of a packet of cones with the test of each, for one ray.
void check_packet(const RayQuery& query, const std::array<RoundCone, kSimdWidth>& cones, const Frame& frame) {
  const Ray ray = prepare(query, frame);
  const float* rows[kSimdWidth];
  for (int i = 0; i < kSimdWidth; ++i) rows[i] = reinterpret_cast<const float*>(&cones[i]);
  FloatX16 floats[8];
  transpose_rows(rows, floats);
  const auto fields = RoundCones::fields(floats, frame);
  const auto test = RoundCones::test<FloatX16>(ray, fields);
  const auto in = test.entry();
  float t[kSimdWidth], s[kSimdWidth], dist2[kSimdWidth], t_in[kSimdWidth], s_in[kSimdWidth], t_out[kSimdWidth];
  test.closest.t.store(t);
  test.closest.s.store(s);
  test.closest.dist2.store(dist2);
  in.t.store(t_in);
  in.s.store(s_in);
  test.exit().store(t_out);
  bool same = true;
  for (int i = 0; i < kSimdWidth; ++i) {
    const auto fields_of_one = fields_of<RoundCones>(cones[i], frame);
    const auto one = RoundCones::test<float>(ray, fields_of_one);
    same &= bool(test.closest.hit.bits() >> i & 1) == one.closest.hit;
    if (!one.closest.hit) continue;
    const auto entry = one.entry();
    same &= t[i] == one.closest.t && s[i] == one.closest.s && dist2[i] == one.closest.dist2 && t_in[i] == entry.t &&
            s_in[i] == entry.s && t_out[i] == one.exit();
  }
  check(same, "a packet has the answers of its cones");
}

/// Check one case with a spread, which has no surface.
void check_spread(const Case& one, const Frame& frame, double size, Worst& worst) {
  const SpreadRay ray = prepare_for<SpreadCones>(one.query, frame);
  const auto closest = SpreadCones::test<float>(ray, fields_of<SpreadCones>(one.cone, frame)).closest;
  const double clearance = one.least_clearance();
  size = size * (1.0 + one.query.spread) + std::max({one.reach(0), one.reach(1), 0.0});
  if (closest.hit != (clearance <= 0)) worst.decision = std::max(worst.decision, std::abs(clearance) / size);
  if (!closest.hit) return;
  ++worst.n_hits;
  // What culling allows for.
  const float radius = SpreadCones::radius(one.cone) * frame.scale;
  check(std::sqrt(closest.dist2) <= ray.radius + radius + ray.eps, "culling reaches each hit");
}

/// What is special about a case.
enum Kind {
  general,
  contained,
  ball,
  thin,
  nearly_parallel,
  parallel,
  larger_than_scene,
  segment,
  nearly_ball,
  tip,
  fine_tip,
  wide_tip,
  n_kinds
};
constexpr const char* kNames[] = {
    "general", "contained",     "ball", "thin",     "nearly parallel", "parallel", "larger than the scene",
    "segment", "nearly a ball", "tip",  "fine tip", "wide tip"};

/// Where a scene of size 2 lies: coordinates are multiplied by `scale`, and then moved by `offset` along each axis.
struct Placement {
  float scale, offset;

  Vec3 operator()(const Vec3& at) const { return at * scale + Vec3{offset, offset, offset}; }
};

Case random_case(Random& random, Kind kind, const Placement& place, bool has_spread) {
  Case one;
  Vec3 p = random.in_cube() * 2.0f - Vec3{1, 1, 1}, q = random.in_cube() * 2.0f - Vec3{1, 1, 1};
  float radius0 = random.uniform() * 0.3f, radius1 = random.uniform() * 0.3f, radius = 0.1f * random.uniform();
  Vec3 direction = random.direction();
  if (kind == contained) q = p + (q - p) * 0.01f;
  if (kind == ball) q = p;
  if (kind == thin) radius0 *= 0.001f, radius1 *= 0.001f, radius *= 0.01f;
  if (kind == nearly_parallel) direction = (q - p) + random.direction() * 0.01f;
  if (kind == parallel) direction = q - p;
  if (kind == larger_than_scene) radius0 *= 20.0f;
  if (kind == segment) radius1 = radius0 = 0.0f;
  if (kind == nearly_ball) radius1 = radius0 + std::sqrt(dot(q - p, q - p)) * 0.999999f;
  float aim = random.uniform(), reach = 1.2f * random.uniform() * (radius0 + radius1 + radius);
  if (kind >= tip) {
    // Aim at the tip or a little beside, from anywhere, along the axis or along the side of the cone.
    const Vec3 axis = q - p;
    const float length = std::sqrt(dot(axis, axis));
    radius0 = length * (kind == wide_tip ? 1.0f - std::pow(10.0f, random.uniform(-7.0f, -1.0f)) : random.uniform());
    radius1 = kind == fine_tip ? std::pow(10.0f, random.uniform(-7.0f, -4.0f)) : 0.0f;
    if (random.uniform() < 0.7f) radius = 0.0f;
    aim = 1.0f, reach = random.uniform() < 0.3f ? 0.0f : std::pow(10.0f, random.uniform(-8.0f, -3.0f));
    const Vec3 across = direction - axis * (dot(direction, axis) / (length * length));
    const float way = random.uniform(), sine = radius0 / length, cosine = std::sqrt(1.0f - sine * sine);
    if (way < 0.2f) direction = axis;
    if (way > 0.8f) direction = axis * cosine + across * (sine * length / std::sqrt(dot(across, across)));
    if (way < 0.1f || way > 0.9f) direction = direction * -1.0f;
  }
  const Vec3 target = p * (1 - aim) + q * aim + random.direction() * reach;
  const Vec3 origin = target - direction * (has_spread ? random.uniform(-1.0f, 4.0f) : 2.0f * random.uniform());
  one.cone = {{place(p), place(q)}, radius0 * place.scale, radius1 * place.scale};
  one.query = {place(origin), direction, 0.0f, kInfinity, radius * place.scale};
  if (random.uniform() < 0.3f) one.query.t_max = 2.0f * place.scale * random.uniform();
  if (has_spread) {
    one.query.spread = std::pow(10.0f, random.uniform(-4.0f, 1.0f));
    if (random.uniform() < 0.5f) one.query.t_min = -kInfinity;
  }
  // Let half of the rays graze the surface, where rounding decides.
  const double touching = one.query.radius + one.least_clearance();
  if (random.uniform() < 0.5f && touching >= 0.0) one.query.radius = float(touching);
  return one;
}

}  // namespace

int main() {
  const char* const given = std::getenv("FASTLINES_TEST_CASES");
  const std::size_t n_cases = given ? std::strtoull(given, nullptr, 10) : 5000;  // of each kind
  return test::run([=] {
    // As fractions of the size of the scene.
    constexpr double max_decision = 4e-7, max_entry = 2e-6;
    Random random{43};
    const auto check_kind = [&](Kind kind, const Placement& place, bool has_spread) {
      const Frame frame = frame_of(Box{place({-1, -1, -1}), place({1, 1, 1})}, 6.0f * place.scale);
      const double size = place.scale * (kind == larger_than_scene ? 6.0 : 1.0);
      Worst worst;
      std::array<RoundCone, kSimdWidth> last{};
      for (std::size_t i = 0; i < n_cases; ++i) {
        const Case one = random_case(random, kind, place, has_spread);
        has_spread ? check_spread(one, frame, size, worst) : check_case(one, frame, size, worst);
        last[i % kSimdWidth] = one.cone;
        if (!has_spread) check_packet(one.query, last, frame);
      }
      std::printf(
          "scale %g, offset %g, %s%s: %zu hits, wrong decisions up to %.2g, entries off by %.2g, exits by %.2g\n",
          double(place.scale), double(place.offset), kNames[kind], has_spread ? " with a spread" : "", worst.n_hits,
          worst.decision, worst.entry, worst.exit);
      check(worst.n_hits > n_cases / 10, "rays hit");
      check(worst.decision <= max_decision, "decisions are right, but for rounding");
      check(std::max(worst.entry, worst.exit) <= max_entry, "entries and exits lie on the surface");
    };
    for (const bool has_spread : {false, true})
      for (const Placement& place : {Placement{1.0f, 0.0f}, {1e-6f, 0.0f}, {1e6f, 0.0f}, {1.0f, 1e4f}})
        for (int kind = 0; kind < n_kinds; ++kind) check_kind(Kind(kind), place, has_spread);
  });
}
