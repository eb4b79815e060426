// Elementary functions of lanes have the errors that their header claims. They and the lobes of hair have the same bits
// on all instruction sets.
#include "fastlines/simd/functions.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include "check.hpp"
#include "fastlines/shading/hair_points.hpp"
#include "fastlines/shading/hair_table.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();

/// The digest of all results. A change of the arithmetic changes it: take the new one, which the test prints.
constexpr std::uint64_t kDigest = 0x2b0185330e0e5970;

/// A digest of the bits of results, which each instruction set must arrive at.
struct Digest {
  std::uint64_t state = 14695981039346656037u;

  void add(const FloatLanes& x) {
    for (int i = 0; i < kLanes; ++i) state = (state ^ std::bit_cast<std::uint32_t>(x[i])) * 1099511628211u;
  }
  void add(const Vec3Lanes& v) { add(v.x), add(v.y), add(v.z); }
};

FloatLanes between(Random& random, float low, float high) {
  FloatLanes x;
  for (int i = 0; i < kLanes; ++i) x.set(i, random.uniform(low, high));
  return x;
}

Vec3Lanes directions(Random& random) {
  return unit({between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)});
}

/// Compares a function with the one in float64; errors are relative to results above `floor`, and to `floor` below.
template <class Function, class Exact>
void check_function(const char* name, float low, float high, double floor, Digest& digest, Function function,
                    Exact exact) {
  constexpr double kClaimed = 3e-7;
  Random random{1};
  for (int round = 0; round < 2000; ++round) {
    FloatLanes x = between(random, low, high);
    if (round == 0) x.set(0, low), x.set(1, high);
    const FloatLanes y = function(x);
    digest.add(y);
    for (int i = 0; i < kLanes; ++i) {
      const double expected = exact(double(x[i]));
      check(std::fabs(double(y[i]) - expected) <= kClaimed * std::max(std::fabs(expected), floor), name);
    }
  }
}

void check_functions(Digest& digest) {
  const auto relative = [&](const char* name, float low, float high, auto function, auto exact) {
    check_function(name, low, high, 0.0, digest, function, exact);
  };
  const auto absolute = [&](const char* name, float low, float high, auto function, auto exact) {
    check_function(name, low, high, 1.0, digest, function, exact);
  };
  using Lanes = const FloatLanes&;
  const auto logarithm = [](double x) { return std::log(x); };
  relative("exp", -86, 88, [](Lanes x) { return exp(x); }, [](double x) { return std::exp(x); });
  relative("log near 1", 0.01f, 3, [](Lanes x) { return log(x); }, logarithm);
  relative("log of large numbers", 1e-30f, 1e30f, [](Lanes x) { return log(x); }, logarithm);
  relative("log of small numbers", 1.2e-38f, 1e-36f, [](Lanes x) { return log(x); }, logarithm);
  absolute("sine", -50, 50, [](Lanes x) { return sincos(x).sin; }, [](double x) { return std::sin(x); });
  absolute("cosine", -50, 50, [](Lanes x) { return sincos(x).cos; }, [](double x) { return std::cos(x); });
  absolute(
      "sine of many turns", 7000, 7999, [](Lanes x) { return sincos(x).sin; }, [](double x) { return std::sin(x); });
  relative("1 / √x", 1e-30f, 1e30f, [](Lanes x) { return inverse_sqrt(x); }, [](double x) { return 1 / std::sqrt(x); });
  relative("asin", -1, 1, [](Lanes x) { return asin(x); }, [](double x) { return std::asin(x); });
  relative("acos", -1, 1, [](Lanes x) { return acos(x); }, [](double x) { return std::acos(x); });
  for (const float of : {1.0f, -1.0f, 0.01f, -0.0f})
    relative("atan2", -2, 2, [of](Lanes y) { return atan2(y, of); }, [of](double y) { return std::atan2(y, of); });
}

/// Functions of numbers at the ends of their domains, and of NaN.
void check_ends() {
  const auto first = [](const FloatLanes& x) { return x[0]; };
  check(first(exp(FloatLanes(-kInf))) == 0.0f && first(exp(FloatLanes(-88.0f))) == 0.0f, "exp vanishes");
  check(first(exp(FloatLanes(0.0f))) == 1.0f && first(log(FloatLanes(1.0f))) == 0.0f, "exp(0) and log(1)");
  check(first(exp(FloatLanes(kInf))) > 1e38f, "exp saturates");
  check(first(pow(0.0f, 2.0f)) == 0.0f && first(pow(0.0f, 0.0f)) == 1.0f, "powers of 0");
  check(std::fabs(first(pow(0.25f, 1.5f)) - 0.125f) < 1e-7f, "pow");
  check(first(atan2(0.0f, 0.0f)) == 0.0f, "the angle of (0, 0)");
  check(first(asin(FloatLanes(1.0f))) == 0.5f * kPi && first(acos(FloatLanes(1.0f))) == 0.0f, "asin and acos of 1");
  check(first(acos(FloatLanes(-1.0f))) == kPi, "acos(-1)");
  const FloatLanes nan = kNan;
  for (const FloatLanes& y : {exp(nan), sincos(nan).sin, sincos(nan).cos, asin(nan), acos(nan), atan2(nan, nan),
                              atan2(nan, 1.0f), atan2(1.0f, nan)})
    check(y[0] != y[0], "NaN stays NaN");
}

void check_lanes(Random& random) {
  const FloatLanes x = between(random, -9, 9), y = between(random, -9, 9), root = sqrt(abs(x)), whole = round(x);
  const FloatLanes signs = times_sign(x, y), least = min(x, y), most = max(x, y), bounded = clamp(x, -1.0f, 2.0f);
  const IntLanes truncated = to_int(x);
  float rows[3 * kLanes], stored[kLanes + 1] = {};
  const Vec3Lanes points{x, y, root};
  points.store(rows, kLanes);
  const Vec3Lanes loaded = Vec3Lanes::load(rows, 5);
  store_lanes(x, stored, 7);
  for (int i = 0; i < kLanes; ++i) {
    check(root[i] == std::sqrt(std::fabs(x[i])) && whole[i] == std::nearbyint(x[i]), "sqrt and round");
    check(signs[i] == (y[i] < 0 ? -x[i] : x[i]) && truncated[i] == std::int32_t(x[i]), "times_sign and to_int");
    check(least[i] == std::min(x[i], y[i]) && most[i] == std::max(x[i], y[i]), "min and max");
    check(bounded[i] == std::clamp(x[i], -1.0f, 2.0f), "clamp");
    const int row = std::min(i, 4);
    check(loaded.x[i] == x[row] && loaded.y[i] == y[row] && loaded.z[i] == root[row], "rows repeat the last one");
    check(stored[i] == (i < 7 ? x[i] : 0.0f), "only the first lanes are stored");
  }
}

HairMaterial material(double roughness) {
  const double v = roughness * roughness;
  return HairMaterial({0.5, 0.9, 1.8, 1.55, v, 0.25 * v, 4 * v, 4 * v, -0.07, 0.035, 0.14, 0.0, roughness});
}

/// Adds values and samples of hair to the digest, and checks that they are finite.
void check_hair(double roughness, Digest& digest) {
  Random random{2};
  const HairMaterial made = material(roughness);
  std::vector<float> azimuths(3 * 4 * HairTable::kValues), inclinations(3 * HairTable::kRest);
  for (float& each : azimuths) each = random.uniform();
  for (float& each : inclinations) each = random.uniform();
  const HairTable table(made, azimuths.data(), inclinations.data(), 3, 4);
  for (int round = 0; round < 200; ++round) {
    const Vec3Lanes tangents = directions(random), to_eye = round % 4 ? directions(random) : tangents;
    const FloatLanes h = round % 3 ? between(random, -1, 1) : FloatLanes(round % 2 ? 1.0f : -1.0f);
    const HairPoints points(made, to_eye, tangents, h);
    const FloatLanes u[] = {between(random, 0, 1), between(random, 0, 1), between(random, 0, 1), between(random, 0, 1)};
    const HairPoints::Sampled drawn = points.sample(u);
    const Vec3Lanes value = points.evaluate(drawn.towards), even = points.evaluate(directions(random));
    const Vec3Lanes far = table.evaluate(h, u[0], 9.0f * u[1]);
    for (const Vec3Lanes& v : {drawn.towards, drawn.weight, value, even, far, table.forward(h), table.backward(u[2])}) {
      digest.add(v);
      for (int i = 0; i < kLanes; ++i)
        check(std::isfinite(v.x[i]) && std::isfinite(v.y[i]) && std::isfinite(v.z[i]), "values of hair are finite");
    }
    const Vec3Lanes weighed = drawn.pdf * drawn.weight;
    const FloatLanes density = points.pdf(drawn.towards);
    for (int i = 0; i < kLanes; ++i) {
      check(std::fabs(weighed.x[i] - value.x[i]) <= 1e-6f * value.x[i], "the weight is value over density");
      check(drawn.pdf[i] == density[i] && density[i] > 0.0f, "pdf is the density of samples");
    }
  }
}

}  // namespace

int main() {
  return test::run([] {
    Digest digest;
    check_functions(digest);
    check_ends();
    Random random{3};
    for (int round = 0; round < 100; ++round) check_lanes(random);
    for (const double roughness : {0.001, 0.2, 2.0}) check_hair(roughness, digest);
    std::printf("digest: %#llx\n", static_cast<unsigned long long>(digest.state));
    check(digest.state == kDigest, "all instruction sets have the same bits");
  });
}
