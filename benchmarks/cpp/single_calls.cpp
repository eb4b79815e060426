// Times calls with one ray each, as a renderer makes them: rays that pass the scene, that cross it between its lines,
// and that hit a line. Prints the nanoseconds of a call, the least of many rounds.
//
//     g++ -std=c++20 -O2 benchmarks/cpp/single_calls.cpp $(python -m fastlines --cflags --libs) -o single_calls
//     ./single_calls
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fastlines/fastlines.hpp>
#include <random>

namespace {

constexpr int kRays = 500, kRounds = 3000, kLines = 20'000;
constexpr float kRadius = 0.001f;

using Random = std::mt19937;
float uniform(Random& random, float low, float high) { return low + (high - low) * float(random() >> 8) * 0x1p-24f; }
fl::Vec3 point(Random& random, float low, float high) {
  const float x = uniform(random, low, high), y = uniform(random, low, high), z = uniform(random, low, high);
  return {x, y, z};
}

/// The nanoseconds of call(ray).
template <class Call>
double time_of(const std::vector<fl::Ray>& rays, Call&& call) {
  double least = 1e30;
  for (int round = 0; round < kRounds; ++round) {
    const auto start = std::chrono::steady_clock::now();
    for (const fl::Ray& ray : rays) call(ray);
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    least = std::min(least, taken.count() / double(rays.size()));
  }
  return least;
}

}  // namespace

int main() {
  Random random(1);
  std::vector<fl::Segment> lines;
  for (int i = 0; i < kLines; ++i) {
    const fl::Vec3 p = point(random, 0, 1), e = point(random, -0.05f, 0.05f);
    lines.push_back({p, {p.x + e.x, p.y + e.y, p.z + e.z}});
  }
  const fl::Tree tree = fl::build(lines);

  // Sort random rays by what happens to them.
  std::vector<fl::Ray> past, outwards, between, hitting;
  const auto is_full = [](const std::vector<fl::Ray>& rays) { return rays.size() == kRays; };
  while (!is_full(past) || !is_full(outwards) || !is_full(between) || !is_full(hitting)) {
    const fl::Vec3 origin = point(random, -4, 5), target = point(random, -2, 3);
    const fl::Vec3 inside = point(random, 0, 1);
    const fl::Ray far(origin, {target.x - origin.x, target.y - origin.y, target.z - origin.z});
    const fl::Ray near(inside, point(random, -1, 1), 0, 0.1f);
    const fl::Ray away({origin.x, origin.y, 1.2f}, {target.x, target.y, 1});
    if (!is_full(outwards)) outwards.push_back(away);
    if (tree.count_hits(far, 0.5f) == 0 && !is_full(past)) past.push_back(far);
    if (!tree.any_hit(near, kRadius) && !is_full(between)) between.push_back(near);
    if (tree.any_hit(far, kRadius) && !is_full(hitting)) hitting.push_back(far);
  }
  std::printf("%-32s %10s %10s\n", "ns a call", "first_hit", "any_hit");
  std::size_t n = 0;  // so that no call is left out
  for (const auto& [name, rays] : {std::pair("rays that pass the scene", &past),
                                   {"rays that leave the scene", &outwards},
                                   {"short rays that hit nothing", &between},
                                   {"rays that hit", &hitting}})
    std::printf("%-32s %10.1f %10.1f\n", name,
                time_of(*rays, [&](const fl::Ray& ray) { n += tree.first_hit(ray, kRadius).prim >= 0; }),
                time_of(*rays, [&](const fl::Ray& ray) { n += tree.any_hit(ray, kRadius); }));
  return n == 0;
}
