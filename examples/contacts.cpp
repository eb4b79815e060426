// Which rods of a pile touch each other, and which one is nearest to a point: queries without rays.
//
//     g++ -std=c++20 -O2 examples/contacts.cpp $(python -m fastlines --cflags --libs) -o contacts && ./contacts
#include <algorithm>
#include <cstdio>
#include <fastlines/fastlines.hpp>
#include <random>
#include <vector>

int main() {
  constexpr float radius = 0.01f;
  std::mt19937 random(1);
  const auto uniform = [&](float low, float high) { return low + (high - low) * float(random() / 4294967296.0); };
  std::vector<fl::RoundCone> rods;
  while (rods.size() < 2000) {
    const fl::Vec3 p{uniform(0, 1), uniform(0, 1), uniform(0, 1)};
    const fl::Vec3 q{p.x + uniform(-0.2f, 0.2f), p.y + uniform(-0.2f, 0.2f), p.z + uniform(-0.02f, 0.02f)};
    rods.push_back({p, q, radius, radius});
  }
  const fl::Tree tree = fl::build(rods);

  const fl::Pairs touching = tree.pairs(0.0f);  // surfaces that are at most 0 apart
  float deepest = 0;
  for (std::size_t pair = 0; pair < touching.size(); ++pair) deepest = std::min(deepest, touching[pair].distance);
  std::printf("%zu pairs of rods touch, the deepest by %.3f\n", touching.size(), -deepest);

  const fl::Vec3d point{0.5, 0.5, 2};
  const fl::NearLine nearest = tree.nearest(point);
  const std::size_t n_near = tree.count_within(point, nearest.distance + 0.05f);
  std::printf("rod %d is nearest, %.3f away, and %zu are at most 0.05 farther\n", int(nearest.prim), nearest.distance,
              n_near);
  return nearest ? 0 : 1;
}
