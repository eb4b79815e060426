// Spreads of lines are those of the definition, and only the lines that straddle a plane decide whether a split there
// cuts retraced lines.
#include "fastlines/splits/retraced_lines.hpp"

#include <cmath>
#include <vector>

#include "check.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// The root mean square distance of lines from their mean where they cross x = plane, across the first line.
double spread_of(const std::vector<Segment>& lines, double plane) {
  const Segment& first = lines[0];
  const auto offset = [&](const Segment& line, int k) {
    const auto at = [&](const Segment& of) {
      const double s = (plane - of.p[0]) / (double(of.q[0]) - of.p[0]);
      return of.p[k] + s * (double(of.q[k]) - of.p[k]);
    };
    return at(line) - at(first);
  };
  double length2 = 0.0;
  for (int k = 0; k < 3; ++k) length2 += std::pow(double(first.q[k]) - first.p[k], 2);
  std::vector<double> across;
  double mean[3] = {}, sum = 0.0;
  for (const Segment& line : lines) {
    double along = 0.0;
    for (int k = 0; k < 3; ++k) along += offset(line, k) * (double(first.q[k]) - first.p[k]);
    for (int k = 0; k < 3; ++k) {
      across.push_back(offset(line, k) - along * (double(first.q[k]) - first.p[k]) / length2);
      mean[k] += across.back() / double(lines.size());
    }
  }
  for (std::size_t i = 0; i < across.size(); ++i) sum += std::pow(across[i] - mean[i % 3], 2);
  return std::sqrt(sum / double(lines.size()));
}

/// Lines from x = 0 to 1 that run along each other, within a width.
std::vector<Segment> bundle(Random& random, int n, float width) {
  std::vector<Segment> lines;
  for (int i = 0; i < n; ++i) {
    const Vec3 p = random.direction() * width, q = Vec3{1.0f, 0.7f, 0.4f} + random.direction() * width;
    lines.push_back({{0.0f, p[1], p[2]}, {1.0f, q[1], q[2]}});
  }
  return lines;
}

void check_spread(Random& random) {
  const std::vector<Segment> lines = bundle(random, 2 + int(random.below(20)), 0.2f);
  const float plane = random.uniform(0.1f, 0.9f);
  Spread<Segment> spread(0, plane);
  check(spread.within(0.0), "no lines have no spread");
  for (const Segment& line : lines) spread.add(line);
  const double expected = spread_of(lines, plane);
  check(spread.within(1.001 * expected) && !spread.within(0.999 * expected), "the spread is that of the definition");
}

bool cuts(const std::vector<Segment>& lines, float plane, double distance, BoxRule rule = BoxRule::tight) {
  const Segments prims{{lines.data(), lines.size()}};
  std::vector<BuildRef> refs;
  Candidate split{Candidate::Kind::plane, 0, plane, 0, 0, {}, {}};
  for (std::uint32_t i = 0; i < lines.size(); ++i) {
    refs.push_back({Reference{i}, prims.bounds(i)});
    const Side side = side_of(refs.back().box, 0, plane);
    split.n_left += side != Side::right;
    split.n_right += side != Side::left;
  }
  return cuts_retraced(prims, refs, hull(refs), rule, split, distance);
}

void check_splits(Random& random) {
  std::vector<Segment> lines = bundle(random, 100, 1e-4f);
  check(cuts(lines, 0.5f, 1e-3), "lines that run along each other are retraced");
  check(!cuts(lines, 0.5f, 1e-6) && !cuts(lines, 0.5f, 0.0), "but not within less than their spread");

  // Lines on one side only, far from the others, change nothing until the others are too few.
  std::vector<Segment> many = lines;
  for (int i = 0; i < 60; ++i) {
    const Vec3 at{0.9f, random.uniform(), random.uniform()};
    many.push_back({at, at + Vec3{0.01f, 0.0f, 0.0f}});
  }
  check(cuts(many, 0.5f, 1e-3), "lines that do not straddle the plane do not widen the spread");
  for (int i = 0; i < 60; ++i) many.push_back(many.back());
  check(cuts(many, 0.5f, 1e-3) && !cuts(many, 0.5f, 1e-3, BoxRule::cut), "a KD tree wants half of them to straddle");
  for (int i = 0; i < 200; ++i) many.push_back(many.back());
  check(!cuts(many, 0.5f, 1e-3), "too few straddle the plane");

  // Lines that cross in one point lie apart elsewhere.
  for (Segment& line : lines) {
    const Vec3 p{-0.5f, random.uniform(-0.4f, 0.4f), random.uniform(-0.4f, 0.4f)};
    line = {p, p * -1.0f};
  }
  check(!cuts(lines, 0.0f, 1e-3), "a star of lines is not retraced");
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    for (int round = 0; round < 200; ++round) {
      check_spread(random);
      check_splits(random);
    }
  });
}
