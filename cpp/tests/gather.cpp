// Sums over hits: every kernel gives the bits of a search that tests every line, and every instruction set the same.
#include <cinttypes>

#include "check.hpp"
#include "fastlines/query/gather/gather_rays.hpp"
#include "scenes.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// The digest of all sums below. If it differs, sums have changed, on this machine or on all.
constexpr std::uint64_t kDigest = 0xa4aeb302c4bdd4c5;

constexpr int kChannels = 3;

struct Sums {
  std::vector<double> sum, squares;
  std::vector<std::int64_t> count;

  explicit Sums(std::size_t n) : sum(n * kChannels), squares(n * kChannels), count(n) {}
  GatherSums arrays() { return {sum.data(), squares.data(), count.data(), kChannels}; }
  bool operator==(const Sums&) const = default;
};

std::vector<RoundCone> cones_on(const test::Lines& lines) {
  std::vector<RoundCone> cones;
  for (std::size_t i = 0; i < lines.size(); ++i)
    cones.push_back({lines[i], 0.01f * float(i % 3), 0.01f * float(i % 5)});
  return cones;
}

/// Rules that read all that a contribution depends on.
std::vector<GatherRule> rules_for(std::span<const float> values, std::span<const float> depths) {
  GatherRule counted, beams, on_grid;
  for (GatherRule* rule : {&counted, &beams, &on_grid}) rule->n_channels = kChannels;
  counted.blur = Blur::none;
  beams.values = on_grid.values = values;
  beams.sigma = {0.5f, 1.0f, 2.0f};
  beams.line_sigma = {0.1f, 0.0f, 3.0f};
  beams.phase = 0.7f;
  on_grid.blur = Blur::epanechnikov;
  on_grid.inner = false;
  on_grid.depths = depths;
  on_grid.n_depths = 4;
  on_grid.phase = -0.9f;
  return {counted, beams, on_grid};
}

/// Add the sums of a set of lines to a digest.
template <class P>
void check_sums(const P& prims, std::span<const Segment> axes, const RayBatch& rays, std::uint64_t& digest) {
  Progress progress;
  Settings settings;
  const Segments built{axes};
  const Tree tree = Builder<Segments>(built, settings, progress).build();
  const WideBvh layout = collapse<P>(tree.nodes, tree.refs, prims, {}, 1, progress);
  const WideBvhView<P> view = view_of(layout, prims);
  const BruteForce<P> brute{prims, frame_of(bounds_of_all(prims), max_radius_of(prims))};
  const GatherLines lines{reinterpret_cast<const float*>(prims.items()), sizeof(typename P::Item) / sizeof(float)};
  Random random{9};
  std::vector<float> values(prims.size() * kChannels), depths(rays.size() * 4);
  for (float& value : values) value = random.uniform(-1.0f, 2.0f);
  for (std::size_t i = 0; i < depths.size(); ++i) depths[i] = random.uniform() + (i % 4 ? depths[i - 1] : 0.0f);
  std::int64_t n_counted = 0;
  for (const GatherRule& rule : rules_for(values, depths)) {
    Sums expected(rays.size());
    gather_rays(brute, rays, rule, lines, 1, progress, expected.arrays());
    for (const Kernel kernel : {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle}) {
      Sums found(rays.size());
      run_batch(view, rays, kernel, GatherQuery<P>(view, rays, rule, found.arrays()), 2, progress);
      check(found == expected, "a kernel sums to the bits of brute force");
    }
    for (const auto* sums : {&expected.sum, &expected.squares})
      for (const double sum : *sums) digest = (digest ^ std::bit_cast<std::uint64_t>(sum)) * 0x100'0000'01b3;
    for (const std::int64_t n : expected.count) n_counted += n;
  }
  check(n_counted > 300, "many hits count");
}

void check_exact_sums() {
  Random random{3};
  std::vector<double> numbers;
  for (int i = 0; i < 160; ++i)
    numbers.push_back(random.uniform(-1.0f, 1.0f) * std::ldexp(1.0, -int(random.below(60))));
  const auto total = [&] {
    ExactSum sum(1.0, numbers.size());
    for (std::size_t first = 0; first < numbers.size(); first += kLanes) {
      double x[kLanes];
      std::copy_n(numbers.begin() + std::ptrdiff_t(first), kLanes, x);
      sum.add(x);
    }
    return sum.total();
  };
  const double before = total();
  for (std::size_t i = numbers.size(); i > 1; --i) std::swap(numbers[i - 1], numbers[random.below(i)]);
  check(total() == before, "the order of numbers does not matter");
  double expected = 0.0;
  for (const double x : numbers) expected += x;
  check(std::abs(before - expected) < 1e-12, "the sum is that of the numbers");
}

void check_gather() {
  check_exact_sums();
  std::uint64_t digest = 0xcbf2'9ce4'8422'2325;
  const test::Lines lines = test::hair(40);
  const std::vector<RoundCone> cones = cones_on(lines);
  test::Rays rays = test::scattered(lines, bounds_of_all(Segments{lines}), 1.0f);
  for (float& t : rays.t_max) t = std::min(t, 10.0f);
  check_sums(RoundCones(cones), lines, rays.batch(), digest);
  const test::Rays picture =
      test::picture("picture", {0.3f, 0.2f, 2.0f}, 1.0f, bounds_of_all(Segments{lines}), 1.0f, 0.03f);
  RayBatch batch = picture.batch();
  const float end[] = {5.0f};
  batch.t_max = end;
  check_sums(Segments{lines}, lines, batch, digest);
  if (digest != kDigest) std::printf("the digest is %#" PRIx64 "\n", digest);
  check(digest == kDigest, "all instruction sets sum to the same bits");
}

}  // namespace

int main() { return test::run(check_gather); }
