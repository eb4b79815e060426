// Every vector operation gives in each lane the result of the scalar one, bit for bit. Transposes, compress and permute
// move lanes to the right places.
#include "fastlines/simd/float_x16.hpp"

#include <bit>
#include <limits>

#include "check.hpp"
#include "fastlines/simd/float_x8.hpp"
#include "fastlines/simd/transpose.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

struct Lanes {
  alignas(64) float x[kSimdWidth];

  Lanes() = default;
  Lanes(FloatX16 from) { from.store(x); }
  FloatX16 vector() const { return FloatX16::load(x); }
  float operator[](int i) const { return x[i]; }
};

/// Whether two floats have the same bits, or are both NaN.
bool same(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (a != a && b != b);
}

float any_float(Random& random) {
  constexpr float kOdd[] = {
      0.0f, -0.0f, 1.0f, -1.0f, kInfinity, -kInfinity, 1e-40f, 3e38f, std::numeric_limits<float>::quiet_NaN()};
  const std::size_t which = random.below(3 * std::size(kOdd));
  return which < std::size(kOdd) ? kOdd[which] : random.uniform(-4.0f, 4.0f);
}

Lanes any_lanes(Random& random) {
  Lanes lanes;
  for (float& x : lanes.x) x = any_float(random);
  return lanes;
}

template <class Op>
void check_each(const char* name, const Lanes& x, const Lanes& y, Op op) {
  const Lanes got = op(x.vector(), y.vector());
  for (int i = 0; i < kSimdWidth; ++i) check(same(got[i], op(x[i], y[i])), name);
}

/// The least of some lanes: its lane, up to the last four bits, and a lower bound.
void check_least_lane(Random& random) {
  Lanes lanes;
  for (float& x : lanes.x) x = random.below(4) ? random.uniform(-4.0f, 4.0f) : random.below(2) ? kInfinity : -0.0f;
  const auto bits = std::uint32_t(1 + random.below(0xffff));
  float at_least = 0.0f;
  const std::uint32_t lane = least_lane(bits, lanes.vector(), at_least);
  check(lane < kSimdWidth && (bits >> lane & 1), "the least lane is one of those that are chosen");
  for (int i = 0; i < kSimdWidth; ++i)
    if (bits >> i & 1) {
      check(at_least <= lanes[i], "no chosen lane is less than the lower bound");
      check(lanes[int(lane)] <= lanes[i] + std::fabs(lanes[i]) * 0x1p-18f, "no chosen lane is less than the least");
    }
}

void check_arithmetic(const Lanes& x, const Lanes& y) {
  check_each("x + y", x, y, [](auto a, auto b) { return a + b; });
  check_each("x - y", x, y, [](auto a, auto b) { return a - b; });
  check_each("x * y", x, y, [](auto a, auto b) { return a * b; });
  check_each("x / y", x, y, [](auto a, auto b) { return a / b; });
  check_each("min(x, y)", x, y, [](auto a, auto b) { return min(a, b); });
  check_each("max(x, y)", x, y, [](auto a, auto b) { return max(a, b); });
  check_each("sqrt(x)", x, y, [](auto a, auto) { return fastlines::sqrt(a); });
  check_each("abs(x)", x, y, [](auto a, auto) { return fastlines::abs(a); });
  check_each("x <= y", x, y, [](auto a, auto b) { return blend(a <= b, a, b); });
  check_each("x < y", x, y, [](auto a, auto b) { return blend(a < b, a, b); });
  check_each("x <= y and x < 1, or y < x", x, y, [](auto a, auto b) {
    const decltype(a) one = 1.0f;
    return blend(((a <= b) & (a < one)) | (b < a), a, b);
  });
}

/// fma may round once or twice, so its result is compared with a tolerance.
void check_fma(Random& random) {
  Lanes x, y, z;
  for (int i = 0; i < kSimdWidth; ++i)
    x.x[i] = random.uniform(-1, 1), y.x[i] = random.uniform(-1, 1), z.x[i] = random.uniform(-1, 1);
  const Lanes sum = fma(x.vector(), y.vector(), z.vector()), difference = fnma(x.vector(), y.vector(), z.vector());
  for (int i = 0; i < kSimdWidth; ++i) {
    const double product = double(x[i]) * double(y[i]);
    check(std::fabs(sum[i] - (z[i] + product)) < 3e-7, "fma(x, y, z)");
    check(std::fabs(difference[i] - (z[i] - product)) < 3e-7, "fnma(x, y, z)");
    check(std::fabs(fastlines::fma(x[i], y[i], z[i]) - (z[i] + product)) < 3e-7, "fma(x, y, z) of one float");
  }
}

void check_bits(const Lanes& x, const Lanes& y, const Lanes& z, std::uint32_t bits) {
  const Lanes blended = blend(bits, x.vector(), y.vector());
  const std::uint32_t less = (x.vector() < y.vector()).bits();
  const std::uint32_t positive = nonnegative_mask(x.vector(), y.vector(), z.vector(), blended.vector());
  for (int i = 0; i < kSimdWidth; ++i) {
    check(same(blended[i], bits >> i & 1 ? x[i] : y[i]), "blend by bits");
    check((less >> i & 1) == (x[i] < y[i]), "bits");
    const auto negative = [i](const Lanes& of) { return std::signbit(of[i]); };
    const bool is_negative = (negative(x) || negative(y)) && negative(z) && negative(blended);
    check((positive >> i & 1) != is_negative, "nonnegative_mask: x and y, or z, or w");
  }
  check(any(x.vector() < y.vector()) == (less != 0), "any");
}

void check_compress(const Lanes& x, std::uint32_t bits, std::uint32_t base) {
  float packed[2 * kSimdWidth];
  std::uint32_t numbers[2 * kSimdWidth], flags[kSimdWidth];
  compress(bits, x.vector(), packed);
  compress_indices(bits, base, numbers);
  for (int i = 0, n = 0; i < kSimdWidth; ++i) {
    flags[i] = bits >> i & 1 ? base | 1 : 0;
    if (!(bits >> i & 1)) continue;
    check(same(packed[n], x[i]), "compress");
    check(numbers[n] == base + std::uint32_t(i), "compress_indices");
    ++n;
  }
  check(nonzero_mask(flags) == bits, "nonzero_mask");
}

void check_tables(Random& random) {
  Lanes table = any_lanes(random);
  std::uint32_t index[kSimdWidth];
  std::uint8_t bytes[kSimdWidth];
  double doubles[kSimdWidth], found[kSimdWidth];
  for (int i = 0; i < kSimdWidth; ++i) {
    index[i] = std::uint32_t(random());
    bytes[i] = std::uint8_t(random());
    doubles[i] = random.uniform();
  }
  const Lanes permuted = FloatX16::permute(table.x, index), of_bytes = FloatX16::bytes(bytes);
  FloatX16::permute(doubles, index, found);
  for (int i = 0; i < kSimdWidth; ++i) {
    check(same(permuted[i], table[int(index[i] % 16)]), "permute");
    check(found[i] == doubles[index[i] % 16], "permute in doubles");
    check(of_bytes[i] == float(bytes[i]), "bytes");
  }
  float smallest = kInfinity;
  for (float& x : table.x) x = random.uniform(-1, 1), smallest = std::min(smallest, x);
  check(reduce_min(table.vector()) == smallest, "reduce_min");
}

void check_transposes(Random& random) {
  float rows[kSimdWidth][8];
  const float* at[kSimdWidth];
  for (int i = 0; i < kSimdWidth; ++i) {
    for (float& x : rows[i]) x = any_float(random);
    at[i] = rows[i];
  }
  FloatX16 columns[6];
  transpose_rows(at, columns);
  for (int k = 0; k < 6; ++k)
    for (int i = 0; i < kSimdWidth; ++i) check(same(Lanes(columns[k])[i], rows[i][k]), "transpose_rows");

  Lanes wide[8];
  for (Lanes& lanes : wide) lanes = any_lanes(random);
  struct alignas(32) Row {
    float x[8];
  } transposed[kSimdWidth];
  transpose_columns<8>([&](int k) { return wide[k].x; }, transposed);
  for (int k = 0; k < 8; ++k)
    for (int i = 0; i < kSimdWidth; ++i) check(same(transposed[i].x[k], wide[k][i]), "transpose_columns");

  float points[kSimdWidth][3];
  for (auto& point : points)
    for (float& x : point) x = any_float(random);
  const float* const fours[4] = {points[0], points[4], points[8], points[12]};
  FloatX16 xyz[3];
  transpose_points(fours, xyz);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < kSimdWidth; ++i) check(same(Lanes(xyz[k])[i], points[i][k]), "transpose_points");

  FloatX4 from[4], to[4];
  for (int i = 0; i < 4; ++i) from[i] = load_x4(rows[i]);
  transpose(from, to);
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) check(same(to[k][i], rows[i][k]), "transpose of four by four");
}

void check_float_x8(Random& random) {
  FloatX8 x{}, y{};
  for (int i = 0; i < 8; ++i) x[i] = float(random.below(5)), y[i] = float(random.below(5));
  unsigned less = 0, least_at = 0;
  for (unsigned i = 0; i < 8; ++i) {
    less |= unsigned(x[i] < y[i]) << i;
    if (x[i] < x[least_at]) least_at = i;
  }
  check(bits_of(x < y) == less, "bits_of");
  check(count_set(x < y) == unsigned(std::popcount(less)), "count_set");
  check(index_of_min(x) == least_at, "index_of_min: the lowest lane of the minimum");

  FloatX4 fours[8];
  for (FloatX4& row : fours) row = FloatX4{any_float(random), any_float(random), any_float(random), any_float(random)};
  FloatX8 eights[3];
  transpose(fours, eights);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 8; ++i) check(same(eights[k][i], fours[i][k]), "transpose of eight by three");
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    for (int round = 0; round < 500; ++round) {
      const Lanes x = any_lanes(random), y = any_lanes(random), z = any_lanes(random);
      const auto bits = std::uint32_t(random() & 0xffff);
      check_arithmetic(x, y);
      check_fma(random);
      check_bits(x, y, z, bits);
      check_least_lane(random);
      check_compress(x, bits, std::uint32_t(random() % 1000));
      check_tables(random);
      check_transposes(random);
      check_float_x8(random);
    }
  });
}
